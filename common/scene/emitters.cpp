// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/scene/emitters.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>

#include "common/scene/light.h"

namespace pim {
namespace {

using Corners = std::array<Vec3d, 3>;

constexpr double kSameCorner = 1e-6;  // of the largest extent: nearer corners are one
constexpr double kFacesOneWay = 0.9;  // |sum of area vectors| / area; 1 for a plane, 0 for a closed surface
constexpr double kInFront = 1e-3;     // of the panel's mean width
constexpr double kLeastSize = 1e-9;   // m, of a rectangle in a description

Vec3d area_vector(const Corners& c) { return 0.5 * (c[1] - c[0]).cross(c[2] - c[0]); }

double total_area(const std::vector<Corners>& triangles) {
    double area = 0;
    for (const Corners& t : triangles) area += area_vector(t).length();
    return area;
}

// Which triangles belong together (disjoint sets).
class Parts {
  public:
    explicit Parts(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
    std::size_t part_of(std::size_t i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::size_t a, std::size_t b) {  // the first of a part leads it: parts keep the file's order
        const auto [first, second] = std::minmax({part_of(a), part_of(b)});
        parent_[second] = first;
    }

  private:
    std::vector<std::size_t> parent_;
};

struct PlacedCorner {
    double along;
    Vec3d position;
    std::size_t triangle;
};

// In order along a direction in which the corners of regular meshes hardly ever coincide; not longer than 1,
// so that near corners are near along it.
std::vector<PlacedCorner> ordered_corners(const std::vector<Corners>& triangles) {
    const Vec3d direction(0.3719, 0.5331, 0.7568);
    std::vector<PlacedCorner> corners;
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (const Vec3d& p : triangles[t]) corners.push_back({p.dot(direction), p, t});
    std::ranges::sort(corners, {}, &PlacedCorner::along);
    return corners;
}

Parts connect(const std::vector<Corners>& triangles) {
    Box3d box;
    for (const Corners& t : triangles)
        for (const Vec3d& p : t) box.extendBy(p);
    const Vec3d extent = box.size();
    const double reach = kSameCorner * std::max({extent.x, extent.y, extent.z});
    const auto corners = ordered_corners(triangles);
    Parts parts(triangles.size());
    for (auto a = corners.begin(); a != corners.end(); ++a)
        for (auto b = a + 1; b != corners.end() && b->along - a->along <= reach; ++b)
            if ((b->position - a->position).length() <= reach) {
                parts.join(a->triangle, b->triangle);
                break;  // b goes on to the next corner in this place
            }
    return parts;
}

struct Range {
    double low = INFINITY, high = -INFINITY;
    double length() const { return high - low; }
};

Range range_along(const std::vector<Corners>& triangles, const Vec3d& origin, const Vec3d& direction) {
    Range range;
    for (const Corners& t : triangles)
        for (const Vec3d& p : t) {
            const double along = (p - origin).dot(direction);
            range.low = std::min(range.low, along);
            range.high = std::max(range.high, along);
        }
    return range;
}

EmitterPanel panel_of(const std::vector<Corners>& triangles, const Emitter& emitter, const Vec3d& normal) {
    const RectangleShape shape({1, 1}, Vec3(normal));
    const auto extent = [&](const Vec3& axis) {
        return range_along(triangles, emitter.centroid, Vec3d(axis)).length();
    };
    const double width = extent(shape.axes[0]), height = extent(shape.axes[1]);
    // A surface that is no rectangle along these axes fills less than its extents.
    const double shrink = std::sqrt(emitter.area / (width * height));
    const double front = range_along(triangles, emitter.centroid, normal).high;
    return {.normal = shape.normal,
            .width = std::max(width * shrink, kLeastSize),
            .height = std::max(height * shrink, kLeastSize),
            .centre = emitter.centroid + normal * (front + kInFront * std::sqrt(emitter.area))};
}

Emitter describe(const std::vector<Corners>& triangles) {
    Emitter emitter;
    emitter.area = total_area(triangles);
    Vec3d facing(0);
    for (const Corners& t : triangles) {
        const Vec3d vector = area_vector(t);
        emitter.centroid += (t[0] + t[1] + t[2]) * (vector.length() / 3);
        facing += vector;
    }
    emitter.centroid /= emitter.area;
    if (facing.length() >= kFacesOneWay * emitter.area)
        emitter.panel = panel_of(triangles, emitter, facing.normalized());
    return emitter;
}

// TOML's quoted strings are JSON's, but for DEL.
std::string quoted(const std::string& text) {
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

template <class Vector>
std::string numbers(const Vector& v) {
    return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", v.x + 0, v.y + 0, v.z + 0);  // + 0: no -0
}

}  // namespace

std::vector<Emitter> find_emitters(const std::vector<Corners>& triangles) {
    std::vector<Corners> sound;
    for (const Corners& t : triangles) {
        const double area = area_vector(t).length();
        if (std::isfinite(area) && area > 0) sound.push_back(t);
    }
    Parts parts = connect(sound);
    std::map<std::size_t, std::vector<Corners>> by_part;
    for (std::size_t t = 0; t < sound.size(); ++t) by_part[parts.part_of(t)].push_back(sound[t]);
    std::multimap<double, const std::vector<Corners>*, std::greater<>> by_area;
    for (const auto& [_, part] : by_part) by_area.emplace(total_area(part), &part);
    std::vector<Emitter> emitters;
    for (const auto& [_, part] : by_area) emitters.push_back(describe(*part));
    return emitters;
}

std::string light_lines(const Emitter& emitter, const Rgb& radiance, const std::string& name) {
    const std::string power = numbers(Vec3d(radiance) * (std::numbers::pi * emitter.area));
    if (const auto& panel = emitter.panel)
        return fmt::format(
            "[[light]]\nname = {}\ntype = \"rectangle\"\nsize = [{:.9g}, {:.9g}]\nnormal = {}\n"
            "power = {}\nposition = {}",
            quoted(name), panel->width, panel->height, numbers(panel->normal), power, numbers(panel->centre));
    return fmt::format(
        "[[light]]  # in the middle of its shape: take that out of the geometry file, for it casts shadows\n"
        "name = {}\ntype = \"point\"\npower = {}\nposition = {}",
        quoted(name), power, numbers(emitter.centroid));
}

}  // namespace pim
