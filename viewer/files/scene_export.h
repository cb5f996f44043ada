// SPDX-License-Identifier: GPL-3.0-or-later
// What is seen, for other renderers: a folder with scene.json and the textures as linear EXR. Lengths in
// metres, local coordinates (see geometry.h: world minus `origin`), colours linear, Rec. 709 primaries.
//
//     origin           world position of the local origin
//     vertices         [x, y, z] each
//     normals          of the vertices, to be interpolated and normalised; [0, 0, 0]: the triangle is flat
//     uv               of the vertices; (0, 0) is the lower left corner of the texture, which repeats
//     triangles        [vertex, vertex, vertex, material]; counter-clockwise seen from the front
//     materials        name, diffuse, specular: reflectances, both sides alike; texture: file or null, which
//                      multiplies diffuse, and specular where texture_tints_specular; glass, ior: of the
//                      solid behind the surface; glass has no reflectances
//     lights           name, type "point" or "rectangle", position, power (W, radiant flux per channel, as
//                      the lamp shines now); a rectangle also: size, axes (of its two sides), normal (where
//                      it shines, with the same radiance in all directions; nothing shines behind it)
//     lights_visible   to the camera: rectangles only
//     camera           eye, target, up, vertical_fov (degrees), size (pixels)
//
// The lists vertices, normals and uv are of one length.
#pragma once

#include <filesystem>

#include "common/scene/scene.h"
#include "viewer/view_state.h"

namespace pim {

// The folder is made if its parent exists. scene.json is written last and atomically: where it is, all is.
// Throws Error.
void export_scene(const std::filesystem::path& folder, const Scene& scene, const ViewState& state,
                  const Imath::V2i& size);

}  // namespace pim
