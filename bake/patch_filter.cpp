// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/patch_filter.h"

#include <cmath>
#include <limits>

#include "common/core/parallel.h"

namespace pim {
namespace {

constexpr std::size_t kPatchesAtOnce = 256;
using PerDegree = std::array<double, kDegrees>;

// Calls body(patch) for all patches, several at a time.
template <class Body>
void for_each_patch(std::size_t count, Body body) {
    parallel_for((count + kPatchesAtOnce - 1) / kPatchesAtOnce, [&](std::size_t block) {
        const std::size_t end = std::min(count, (block + 1) * kPatchesAtOnce);
        for (std::size_t p = block * kPatchesAtOnce; p < end; ++p) body(p);
    });
}

// Mean square of the rows of one patch by degree, over channels and terms.
PerDegree mean_squares(const RowMatrix& rows, const std::vector<int>& degrees) {
    PerDegree squares{}, count{};
    for (Eigen::Index k = 0; k < rows.cols(); ++k) {
        squares[std::size_t(degrees[std::size_t(k)])] += rows.col(k).squaredNorm();
        count[std::size_t(degrees[std::size_t(k)])] += double(rows.rows());
    }
    for (std::size_t d = 0; d < kDegrees; ++d)
        if (count[d] > 0) squares[d] /= count[d];
    return squares;
}

enum class Window { near, far };
constexpr std::array kWindows{Window::near, Window::far};

std::span<const uint32_t> members(const Neighbourhoods& shared, Window window, std::size_t patch) {
    return window == Window::near ? shared.near(patch) : shared.far(patch);
}

// The neighbours' mean, the patch itself left out.
struct Guess {
    RowMatrix mean;     // channel × term
    PerDegree noise{};  // its variance
    bool any = false;
};

Guess guess(const NoisyCoefficients& measured, const Neighbourhoods& shared, Window window,
            std::size_t patch) {
    Guess guess{RowMatrix::Zero(3, measured.values.cols())};
    const auto around = members(shared, window, patch);
    double weights = 0;
    for (std::size_t i = 0; i < around.size(); ++i) {
        const uint32_t n = around[i];
        if (n == patch) continue;
        const double far = double(shared.closeness(patch)[i]), near = far * far * far * far;
        const double weight = double(shared.area(n)) * (window == Window::far ? far : near);
        guess.mean += weight * measured.values.middleRows(3 * Eigen::Index(n), 3);
        for (std::size_t d = 0; d < kDegrees; ++d) guess.noise[d] += weight * weight * measured.noise[n][d];
        weights += weight;
    }
    if (!(weights > 0)) return guess;
    guess.any = true;
    guess.mean /= weights;
    for (double& noise : guess.noise) noise /= weights * weights;
    return guess;
}

// How a window serves a patch.
struct Trial {
    PerDegree beyond{};  // mean square of value - guess less the noise of both
    PerDegree noise{};   // of the guess
    bool any = false;
};

std::vector<Trial> trials(const NoisyCoefficients& measured, const Neighbourhoods& shared, Window window) {
    std::vector<Trial> trials(measured.patches());
    for_each_patch(trials.size(), [&](std::size_t p) {
        const Guess g = guess(measured, shared, window, p);
        trials[p].any = g.any;
        if (!g.any) return;
        const RowMatrix apart = measured.values.middleRows(3 * Eigen::Index(p), 3) - g.mean;
        trials[p].noise = g.noise;
        trials[p].beyond = mean_squares(apart, measured.degrees);
        for (std::size_t d = 0; d < kDegrees; ++d) trials[p].beyond[d] -= measured.noise[p][d] + g.noise[d];
    });
    return trials;
}

// Mean square error of a window's guess: the signal's variance about it, pooled, and the guess' own noise.
PerDegree guess_errors(const std::vector<Trial>& trials, const Neighbourhoods& shared, Window window,
                       std::size_t patch) {
    PerDegree errors{};
    double area = 0;
    for (const uint32_t n : members(shared, window, patch)) {
        if (!trials[n].any) continue;
        for (std::size_t d = 0; d < kDegrees; ++d) errors[d] += double(shared.area(n)) * trials[n].beyond[d];
        area += double(shared.area(n));
    }
    for (std::size_t d = 0; d < kDegrees; ++d)
        errors[d] = std::max(0.0, errors[d] / area) + trials[patch].noise[d];
    return errors;
}

// Which window serves each degree of a patch, and how far the patch moves.
struct Choice {
    std::array<Window, kDegrees> window{};
    PerDegree error, share{};

    Choice() { error.fill(std::numeric_limits<double>::infinity()); }
    bool moves(Window w) const {
        for (std::size_t d = 0; d < kDegrees; ++d)
            if (window[d] == w && share[d] > 0) return true;
        return false;
    }
};

Choice choose(const std::array<std::vector<Trial>, 2>& tried, const PerDegree& own,
              const Neighbourhoods& shared, std::size_t patch) {
    Choice choice;
    for (const Window window : kWindows) {
        const auto& trials = tried[std::size_t(window)];
        if (!trials[patch].any) continue;
        const PerDegree errors = guess_errors(trials, shared, window, patch);
        for (std::size_t d = 0; d < kDegrees; ++d)
            if (errors[d] < choice.error[d]) choice.window[d] = window, choice.error[d] = errors[d];
    }
    for (std::size_t d = 0; d < kDegrees; ++d)
        if (own[d] > 0) choice.share[d] = own[d] / (own[d] + choice.error[d]);
    return choice;
}

// What a patch has beyond the mean that the look-up shows of it: channel × term.
RowMatrix beyond_mean(const RowMatrix& values, const LookUpMeans& means, std::size_t patch) {
    RowMatrix beyond = values.middleRows(3 * Eigen::Index(patch), 3);
    for (const auto& s : means.of(patch))
        beyond -= double(s.weight) * values.middleRows(3 * Eigen::Index(s.patch), 3);
    return beyond;
}

struct Detail {
    PerDegree square{}, noise{};  // mean square of it, and what noise makes of that
    double own = 1;               // share of the patch's own noise in it
};

Detail detail(const NoisyCoefficients& c, const LookUpMeans& means, std::size_t patch) {
    Detail detail{.square = mean_squares(beyond_mean(c.values, means, patch), c.degrees)};
    for (const auto& s : means.of(patch)) {
        const auto weight = double(s.weight);
        if (s.patch == patch)
            detail.own -= weight;
        else
            for (std::size_t d = 0; d < kDegrees; ++d)
                detail.noise[d] += weight * weight * c.noise[s.patch][d];
    }
    for (std::size_t d = 0; d < kDegrees; ++d) detail.noise[d] += detail.own * detail.own * c.noise[patch][d];
    return detail;
}

// Mean square of what is no noise in it, over the near window.
PerDegree signal_in(const std::vector<Detail>& details, const Neighbourhoods& shared, std::size_t patch) {
    PerDegree signal{};
    double area = 0;
    for (const uint32_t n : shared.near(patch)) {
        for (std::size_t d = 0; d < kDegrees; ++d)
            signal[d] += double(shared.area(n)) * (details[n].square[d] - details[n].noise[d]);
        area += double(shared.area(n));
    }
    for (double& s : signal) s /= area;
    return signal;
}

}  // namespace

Neighbourhoods::Neighbourhoods(const Cells& cells, bool filter, LookUpMeans means)
    : means_(std::move(means)), filter_(filter) {
    const std::size_t count = cells.patches.size();
    std::vector<std::vector<uint32_t>> of(count);
    near_count_.resize(count);
    for_each_patch(count, [&](std::size_t p) {
        const int reach = filter ? kFarReach : kNearReach;
        std::vector<uint32_t> far;
        for (int x = -reach; x <= reach; ++x)
            for (int y = -reach; y <= reach; ++y)
                for (int z = -reach; z <= reach; ++z) {
                    const int n =
                        cells.index.find(cells.patches[p].cell + Index3(x, y, z), cells.patches[p].slot);
                    if (n < 0) continue;
                    const bool is_near = std::max({std::abs(x), std::abs(y), std::abs(z)}) <= kNearReach;
                    (is_near ? of[p] : far).push_back(uint32_t(n));
                }
        near_count_[p] = uint32_t(of[p].size());
        of[p].insert(of[p].end(), far.begin(), far.end());
    });
    first_.push_back(0);
    std::vector<Vec3> centroid;  // in cells
    for (std::size_t p = 0; p < count; ++p) {
        members_.insert(members_.end(), of[p].begin(), of[p].end());
        first_.push_back(members_.size());
        std::vector<uint32_t>().swap(of[p]);
        const Patch& patch = cells.patches[p];
        area_.push_back(patch.area);
        centroid.push_back(Vec3(patch.cell) + patch.centre / float(cells.grid.cell_size));
    }
    closeness_.resize(members_.size());
    for_each_patch(count, [&](std::size_t p) {
        for (std::size_t i = first_[p]; i < first_[p + 1]; ++i)
            closeness_[i] = std::exp(-(centroid[members_[i]] - centroid[p]).length2() / 8);
    });
}

std::vector<double> pooled_noise(const std::vector<double>& variance, const Neighbourhoods& shared) {
    std::vector<double> pooled(variance.size());
    for_each_patch(variance.size(), [&](std::size_t p) {
        double squares = 0, area = 0;  // variance goes as 1 / area under even light
        for (const uint32_t n : shared.near(p)) {
            squares += double(shared.area(n)) * double(shared.area(n)) * variance[n];
            area += double(shared.area(n));
        }
        pooled[p] = squares / (area * double(shared.area(p)));
    });
    return pooled;
}

NoisyCoefficients filtered(const NoisyCoefficients& measured, const Neighbourhoods& shared) {
    const std::array tried{trials(measured, shared, Window::near), trials(measured, shared, Window::far)};
    NoisyCoefficients result = measured;
    for_each_patch(measured.patches(), [&](std::size_t p) {
        const Choice choice = choose(tried, measured.noise[p], shared, p);
        for (const Window window : kWindows) {
            if (!choice.moves(window)) continue;
            const Guess g = guess(measured, shared, window, p);
            for (Eigen::Index k = 0; k < g.mean.cols(); ++k) {
                const auto d = std::size_t(measured.degrees[std::size_t(k)]);
                if (choice.window[d] != window) continue;
                auto own = result.values.col(k).segment(3 * Eigen::Index(p), 3);
                own += choice.share[d] * (g.mean.col(k) - own);
            }
            for (std::size_t d = 0; d < kDegrees; ++d) {
                if (choice.window[d] != window) continue;
                const double share = choice.share[d];
                result.noise[p][d] =
                    (1 - share) * (1 - share) * measured.noise[p][d] + share * share * g.noise[d];
            }
        }
    });
    return result;
}

void shrink(NoisyCoefficients& coefficients, const Neighbourhoods& shared) {
    const std::size_t count = coefficients.patches();
    std::vector<PerDegree> powers(count);
    for_each_patch(count, [&](std::size_t p) {
        powers[p] =
            mean_squares(coefficients.values.middleRows(3 * Eigen::Index(p), 3), coefficients.degrees);
    });
    for_each_patch(count, [&](std::size_t p) {
        PerDegree signal{};
        double area = 0;
        for (const uint32_t n : shared.near(p)) {
            for (std::size_t d = 1; d < kDegrees; ++d)
                signal[d] += double(shared.area(n)) * (powers[n][d] - coefficients.noise[n][d]);
            area += double(shared.area(n));
        }
        for (Eigen::Index k = 0; k < coefficients.values.cols(); ++k) {
            const auto d = std::size_t(coefficients.degrees[std::size_t(k)]);
            if (d == 0) continue;
            const double tau2 = std::max(0.0, signal[d] / area);
            coefficients.values.col(k).segment(3 * Eigen::Index(p), 3) *=
                tau2 > 0 ? tau2 / (tau2 + coefficients.noise[p][d]) : 0;
        }
    });
}

void sharpen(NoisyCoefficients& coefficients, const Neighbourhoods& shared) {
    const NoisyCoefficients before = coefficients;
    std::vector<Detail> details(before.patches());
    for_each_patch(details.size(), [&](std::size_t p) { details[p] = detail(before, shared.means(), p); });
    for_each_patch(details.size(), [&](std::size_t p) {
        const PerDegree signal = signal_in(details, shared, p);
        const double own = details[p].own;
        PerDegree share{};
        for (std::size_t d = 0; d < kDegrees; ++d) {
            const double noise = details[p].noise[d], harm = own * before.noise[p][d];
            if (signal[d] > harm) share[d] = (signal[d] - harm) / (signal[d] + noise);
            coefficients.noise[p][d] += 2 * share[d] * harm + share[d] * share[d] * noise;
        }
        const RowMatrix beyond = beyond_mean(before.values, shared.means(), p);
        for (Eigen::Index k = 0; k < beyond.cols(); ++k)
            coefficients.values.col(k).segment(3 * Eigen::Index(p), 3) +=
                share[std::size_t(before.degrees[std::size_t(k)])] * beyond.col(k);
    });
}

}  // namespace pim
