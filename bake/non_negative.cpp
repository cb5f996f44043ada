// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/non_negative.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "common/map/illumination_map.h"

namespace pim {
namespace {

constexpr int kMostSplits = 10000;
constexpr double kRounding = 1e-4;    // of the mean: coefficients become floats
constexpr double kNothing = 1e-9;     // of the mean
constexpr double kLittleLost = 0.98;  // a larger share is not worth a quadratic programme
constexpr int kLattice = 7, kMostRounds = 6, kSweeps = 20;
constexpr double kCloseEnough = 1e-3;  // of the mean: how far below zero lattice points may stay

// Bernstein coefficients of 1, u, u², u³ over [-1,1] in degree 3.
constexpr double kPowers[4][4] = {
    {1, 1, 1, 1}, {-1, -1.0 / 3, 1.0 / 3, 1}, {1, -1.0 / 3, -1.0 / 3, 1}, {-1, 1, -1, 1}};

// Of degree 3 in each axis over some box; i + 4j + 16k.
struct Bernstein {
    std::array<double, 64> b{};

    double least() const { return *std::ranges::min_element(b); }
    double least_corner() const {
        double least = std::numeric_limits<double>::infinity();
        for (const int i : {0, 3})
            for (const int j : {0, 12})
                for (const int k : {0, 48}) least = std::min(least, b[std::size_t(i + j + k)]);
        return least;
    }
    // Calls visit(first, step) for the 16 lines of four coefficients along an axis.
    template <class Visit>
    static void for_each_line(int axis, Visit visit) {
        const int step = 1 << 2 * axis;
        for (int n = 0; n < 64; ++n)
            if ((n / step & 3) == 0) visit(std::size_t(n), std::size_t(step));
    }
    // The axis along which the coefficients bend most.
    int widest_axis() const {
        int widest = 0;
        double most = -1;
        for (int axis = 0; axis < 3; ++axis) {
            double range = 0;
            for_each_line(axis, [&](std::size_t n, std::size_t s) {
                for (std::size_t i = 0; i < 2; ++i)
                    range =
                        std::max(range, std::abs(b[n + i * s] - 2 * b[n + (i + 1) * s] + b[n + (i + 2) * s]));
            });
            if (range > most) most = range, widest = axis;
        }
        return widest;
    }
    // de Casteljau at the middle.
    std::array<Bernstein, 2> halves(int axis) const {
        std::array<Bernstein, 2> h{*this, *this};
        for_each_line(axis, [&](std::size_t n, std::size_t s) {
            const double a = b[n], c = b[n + s], d = b[n + 2 * s], e = b[n + 3 * s];
            const double ac = 0.5 * (a + c), cd = 0.5 * (c + d), de = 0.5 * (d + e), acd = 0.5 * (ac + cd),
                         cde = 0.5 * (cd + de), middle = 0.5 * (acd + cde);
            h[0].b[n + s] = ac, h[0].b[n + 2 * s] = acd, h[0].b[n + 3 * s] = middle;
            h[1].b[n] = middle, h[1].b[n + s] = cde, h[1].b[n + 2 * s] = de;
        });
        return h;
    }
};

Bernstein bernstein_of(const Cubic& cubic) {
    Bernstein result;
    for (std::size_t t = 0; t < cubic.size(); ++t) {
        if (cubic[t] == 0) continue;
        const auto& e = kExponents[t];
        for (int k = 0; k < 4; ++k)
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    result.b[std::size_t(i + 4 * j + 16 * k)] +=
                        cubic[t] * kPowers[e[0]][i] * kPowers[e[1]][j] * kPowers[e[2]][k];
    }
    return result;
}

struct Part {
    double least;
    Bernstein bernstein;
    bool operator<(const Part& other) const { return least > other.least; }  // the lowest comes first
};

// Cheaper than any coefficients, and enough for most.
bool is_clearly_positive(const Cubic& cubic) {
    double rest = 0;
    for (std::size_t t = 0; t < cubic.size(); ++t)
        if (t != std::size_t(kConstantTerm)) rest += std::abs(cubic[t]);
    return (1 - kRounding) * cubic[std::size_t(kConstantTerm)] >= rest;
}

}  // namespace

double mean_over_box(const Cubic& cubic) {
    double sum = 0;
    for (std::size_t t = 0; t < cubic.size(); ++t) {
        double part = cubic[t];
        for (const int power : kExponents[t]) part *= power % 2 ? 0 : 1.0 / (power + 1);
        sum += part;
    }
    return sum;
}

double lower_bound_in_box(const Cubic& cubic, double tolerance) {
    const Bernstein whole = bernstein_of(cubic);
    const double mean = mean_over_box(cubic);
    std::priority_queue<Part> parts;
    parts.push({whole.least(), whole});
    double found = whole.least_corner();
    for (int split = 0; split < kMostSplits; ++split) {
        const double bound = parts.top().least;
        const double doubt = (found < 0 ? tolerance : kNothing) * (mean - bound);
        if (bound >= 0 || found - bound <= doubt) break;
        const Bernstein lowest = parts.top().bernstein;
        parts.pop();
        for (const Bernstein& half : lowest.halves(lowest.widest_axis())) {
            found = std::min(found, half.least_corner());
            parts.push({half.least(), half});
        }
    }
    return parts.top().least;
}

double mend_sign(Cubic& cubic) {
    if (is_clearly_positive(cubic)) return 1;
    const double mean = mean_over_box(cubic);
    if (!(mean > 0)) {
        cubic.fill(0);
        return 0;
    }
    Cubic lowered = cubic;
    lowered[std::size_t(kConstantTerm)] -= kRounding * mean;
    const double bound = lower_bound_in_box(lowered);
    if (bound >= 0) return 1;
    const double share = (1 - kRounding) * mean / ((1 - kRounding) * mean - bound);
    for (double& a : cubic) a *= share;
    cubic[std::size_t(kConstantTerm)] += (1 - share) * mean;
    return share;
}

SignMender::SignMender(const Eigen::MatrixXd& solve, const std::vector<int>& terms, int samples,
                       const std::array<bool, 3>& moves)
    : solve_(solve), terms_(terms), constant_(std::sqrt(double(samples))) {
    std::vector<Vec3d> points;
    const auto place = [](int i) { return -std::cos(i * std::numbers::pi / (kLattice - 1)); };
    const auto count = [&](int axis) { return moves[std::size_t(axis)] ? kLattice : 1; };
    for (int i = 0; i < count(0); ++i)
        for (int j = 0; j < count(1); ++j)
            for (int k = 0; k < count(2); ++k)
                points.emplace_back(moves[0] ? place(i) : 0, moves[1] ? place(j) : 0,
                                    moves[2] ? place(k) : 0);
    Eigen::MatrixXd powers(Eigen::Index(points.size()), Eigen::Index(terms.size()));
    for (std::size_t p = 0; p < points.size(); ++p) {
        const auto all = monomials(points[p]);
        for (std::size_t t = 0; t < terms.size(); ++t)
            powers(Eigen::Index(p), Eigen::Index(t)) = all[std::size_t(terms[t])];
    }
    values_ = powers * solve;
    Eigen::RowVectorXd mean(solve.cols());
    for (Eigen::Index r = 0; r < mean.size(); ++r) {
        Eigen::RowVectorXd one = Eigen::RowVectorXd::Zero(mean.size());
        one(r) = 1;
        mean(r) = mean_over_box(cubic(one));
    }
    moves_ = values_ - values_ * mean.transpose() * mean / mean.squaredNorm();
    influence_ = moves_.rowwise().squaredNorm();
}

Cubic SignMender::cubic(const Eigen::RowVectorXd& orthonormal) const {
    const Eigen::VectorXd coefficients = solve_ * orthonormal.transpose();
    Cubic cubic{};
    for (std::size_t t = 0; t < terms_.size(); ++t)
        cubic[std::size_t(terms_[t])] = coefficients(Eigen::Index(t));
    return cubic;
}

void SignMender::lift(Eigen::Ref<Eigen::RowVectorXd> orthonormal) const {
    const double enough = -kCloseEnough * orthonormal(0) / constant_;
    std::vector<Eigen::Index> points;  // that were below zero at some time: few of all
    std::vector<double> pushes;        // along moves_, of each of them
    const auto known = [&](Eigen::Index i) { return std::ranges::find(points, i) != points.end(); };
    for (int round = 0; round < kMostRounds; ++round) {
        const Eigen::VectorXd value = values_ * orthonormal.transpose();
        if (value.minCoeff() >= enough) return;
        for (Eigen::Index i = 0; i < value.size(); ++i)
            if (value(i) < 0 && influence_(i) > 0 && !known(i)) points.push_back(i);
        pushes.resize(points.size(), 0);
        double least = -1;
        for (int sweep = 0; sweep < kSweeps && least < enough; ++sweep) {
            least = 0;
            for (std::size_t k = 0; k < points.size(); ++k) {
                const double own = values_.row(points[k]).dot(orthonormal);
                least = std::min(least, own);
                const double step = std::max(-pushes[k], -own / influence_(points[k]));
                if (step == 0) continue;
                pushes[k] += step;
                orthonormal += step * moves_.row(points[k]);
            }
        }
    }
}

uint8_t SignMender::mend(Cubic& cubic, Eigen::Ref<Eigen::RowVectorXd> orthonormal) const {
    Cubic mended = cubic;
    double share = mend_sign(mended);
    if (share == 1) return 0;
    if (share > 0 && share < kLittleLost) {
        lift(orthonormal);
        cubic = mended = this->cubic(orthonormal);
        share = mend_sign(mended);
    }
    orthonormal *= share;
    orthonormal(0) += (1 - share) * std::max(0.0, mean_over_box(cubic)) * constant_;
    cubic = mended;
    return share > 0 ? kMended : kBlack;
}

}  // namespace pim
