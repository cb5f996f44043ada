// SPDX-License-Identifier: GPL-3.0-or-later
// What the command line asks for.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/render/photon_radiance.h"
#include "viewer/picture.h"
#include "viewer/relight/kernels.h"
#include "viewer/view_state.h"

namespace pim {

// Photons per lamp that a photon map may have: what it keeps of each takes some 150 bytes.
inline constexpr uint64_t kMostPhotons = 100000000;

// As written; `viewer --help` says what each means. Empty: the scene's own, or the default.
struct Arguments {
    std::filesystem::path map, output;
    std::optional<std::filesystem::path> geometry, stats, volume, setup, probe, exported, ptm;
    std::vector<std::filesystem::path> paths;
    std::vector<std::string> lights, gains, colours;  // NAME=value
    std::string camera, eye, target, up, fov, size, direct, indirect, view, exposure, tone_curve;
    std::string ptm_lamp;
    std::string integrator = "polynomial", vector_unit = "auto";
    double frames_per_second = 25;
    int samples = 4;
    std::optional<uint64_t> photons;  // of the photon map
    std::optional<int> nearest, gather;
    uint64_t seed = 1;
    bool show_lamps = false, panels = false, benchmark = false, overwrite = false;
};

// All of these throw UsageError.
ViewState parse_state(const Arguments& arguments, const Scene& scene, const IlluminationMap& map);
Imath::V2i parse_size(const Arguments& arguments, const Camera& camera);
Integrator parse_integrator(const Arguments& arguments);
// The lamp that a polynomial texture map moves: one that shines.
std::size_t parse_ptm_lamp(const Arguments& arguments, const Scene& scene, const ViewState& state);
// Photons as baked unless told otherwise.
PhotonMapOptions parse_photon_map(const Arguments& arguments, const Scene& scene, const ViewState& state);
VectorUnit parse_vector_unit(const Arguments& arguments);

}  // namespace pim
