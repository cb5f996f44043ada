// SPDX-License-Identifier: GPL-3.0-or-later
// A map's polynomials as the frame loop wants them, box by box: read when a lamp comes near, dropped when it
// has gone far.
#pragma once

#include <condition_variable>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>

#include "common/map/map_file.h"
#include "viewer/relight/aligned.h"
#include "viewer/relight/kernels.h"

namespace pim {

// One box of one lamp, its components added up: blocks of kLanes patches, [block][term][channel][lane].
struct PackedBox {
    std::vector<int> terms;
    int channels = 3;  // 1 where the scene is grey
    AlignedVector<float> coefficients;
    std::vector<float> residuals;  // [patch], W/m² per watt

    std::size_t block_length() const { return terms.size() * std::size_t(channels) * kLanes; }
    std::size_t bytes() const { return (coefficients.size() + residuals.size()) * sizeof(float); }
};

// A box that takes part in the present light.
struct ActiveBox {
    std::shared_ptr<const PackedBox> box;
    std::vector<float> monomials;  // of its terms at the lamp's position
    Rgb power;                     // of the lamp, times the box's weight
};

class CoefficientStore {
  public:
    // `components` are added; the map must have them. Both arguments of references outlive the store.
    CoefficientStore(const MapFile& map, std::vector<Component> components);
    ~CoefficientStore();

    // Boxes that make the light of these lamps, those of lamps without power left out. Reads what is missing,
    // has neighbours read in the background and drops boxes that are far. Throws Error, and UsageError for
    // lamps outside their domain; then nothing is dropped.
    std::vector<ActiveBox> active(const std::vector<LightState>& lights);

    // Is nothing left to read in the background?
    bool is_settled() const;
    std::size_t bytes() const;  // held in memory now
    std::size_t boxes() const;  // the same, counted
    // What went wrong in the background since the last call; empty: nothing.
    std::string take_problem();

  private:
    struct Slot {
        std::shared_ptr<const PackedBox> box;
        double distance = std::numeric_limits<double>::infinity();  // from the lamp, half widths
        bool failed = false;                                        // in the background
    };

    std::shared_ptr<const PackedBox> read(std::size_t light, std::size_t box) const;
    std::shared_ptr<const PackedBox> get(std::size_t light, std::size_t box);
    void plan(std::size_t light, const Vec3d& position);
    void drop_far();
    void work(const std::stop_token& stop);

    const MapFile& map_;
    const std::vector<Component> components_;
    mutable std::mutex mutex_;  // of slots_, problem_
    std::mutex reading_;        // of the file
    std::condition_variable_any changed_;
    std::vector<std::vector<Slot>> slots_;  // [light][box]
    std::string problem_;
    std::jthread background_;
};

}  // namespace pim
