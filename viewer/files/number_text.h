// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers as the shortest decimal text that reads back as the same number. Files are read as doubles that are
// then rounded to float; the texts are chosen for just that way back.
#pragma once

#include <array>
#include <string>

#include "common/core/vector.h"
#include "common/scene/geometry.h"

namespace pim {

using NumberTexts = std::array<std::string, 3>;

std::string number_text(float value);  // finite
std::string number_text(double value);
NumberTexts number_texts(const Vec3& values);
NumberTexts number_texts(const Vec3d& values);

std::string commas(const NumberTexts& texts);  // "x,y,z"

// A local position in world coordinates, m: Geometry::to_local of what is read is the position again, as far
// as doubles can tell world coordinates apart.
NumberTexts world_texts(const Geometry& geometry, const Vec3& position);

}  // namespace pim
