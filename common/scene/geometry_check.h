// SPDX-License-Identifier: GPL-3.0-or-later
// Geometry made trustworthy, and what is inside of what. CGAL judges.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/scene/geometry.h"

namespace pim {

struct Mended {
    std::size_t non_finite = 0;    // triangles with a vertex that is no number
    std::size_t degenerate = 0;    // triangles without area
    std::size_t duplicate = 0;     // triangles whose three corners another one has, either way round
    std::size_t unreferenced = 0;  // vertices of no triangle
    std::string text() const;      // empty if nothing was mended
};

// Removes what is counted above; materials, normals and texture coordinates stay with their triangles.
Mended mend(Geometry& geometry);

// The closed objects of a scene, to ask whether a lamp stands inside one.
class Solids {
  public:
    // A closed component is no solid but a room where it holds one of `rooms_seen_from` (cameras) or encloses
    // other geometry.
    Solids(const Geometry& geometry, const std::vector<Vec3>& rooms_seen_from);
    ~Solids();
    // Name of the object that `point` (local) stands inside; empty if none.
    std::string containing(const Vec3& point) const;
    std::vector<std::string> names() const;  // of the objects that are solids

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

// For tests: does the closed triangle meet the closed box? Exact.
bool triangle_meets_box(const std::array<Vec3, 3>& corners, const Box3d& box);

}  // namespace pim
