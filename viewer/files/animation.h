// SPDX-License-Identifier: GPL-3.0-or-later
// What moves while a film is rendered: CSV files of lamps' keys or of a camera's, told apart by their
// columns.
//
//     time,lamp,x,y,z,gain        any of x, y, z and gain may be empty or absent: no key of it at that time
//     time,eye_x,eye_y,eye_z,target_x,target_y,target_z,fov       fov, in degrees, may be empty or absent
//
// Seconds from 0; world coordinates, m. Between keys lamps, gains and fov go straight; the camera goes
// through its keys in a smooth curve (Catmull-Rom, for keys at uneven times). Before the first key and after
// the last all stand still.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "viewer/view_state.h"

namespace pim {

struct Key {
    double time;   // s
    double value;  // of a position: local, m
};

struct LampPath {
    std::size_t lamp;  // in the scene's order
    Box3 domain;
    std::array<std::vector<Key>, 3> position;  // per axis
    std::vector<Key> gain;
    double last_time = -1;  // s, of the latest row
};

struct CameraKey {
    double time;       // s
    Vec3 eye, target;  // local
};

struct Animation {
    std::vector<LampPath> lamps;
    std::vector<CameraKey> camera;
    std::vector<Key> fov;

    // `base` with all that has keys put where it is at `time`; lamps stay inside their domains.
    ViewState at(double time, const ViewState& base) const;

    double duration() const;  // s, from 0 to the last key

    // Frames at times 0, 1/fps, 2/fps, ... up to the duration. Throws UsageError: fps is not above 0, or
    // there are more than a million frames.
    int frame_count(double fps) const;
};

// Throws Error with file, line and column: unknown columns and lamps, times of a lamp or of the camera that
// do not increase, positions outside a domain, one lamp or the camera in two files.
Animation read_animation(const std::vector<std::filesystem::path>& paths, const Scene& scene);

}  // namespace pim
