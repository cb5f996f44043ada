// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/probe.h"

#include <fmt/format.h>

#include <cassert>

#include "common/core/error.h"
#include "common/scene/light.h"
#include "viewer/files/csv.h"
#include "viewer/files/number_text.h"

namespace pim {
namespace {

ProbePoint read_point(const CsvTable& table, const CsvRow& row, const Scene& scene) {
    const auto number = [&](const char* column) { return csv_number(table, row, column); };
    const Vec3d world{number("x"), number("y"), number("z")};
    const Vec3d normal{number("nx"), number("ny"), number("nz")};
    if (!(normal.length() > 0)) fail(table, row, "nx", "the normal nx,ny,nz must not be 0,0,0");
    return {world, scene.geometry.to_local(world), Vec3(normal.normalized())};
}

}  // namespace

std::vector<ProbePoint> read_probe(const std::filesystem::path& path, const Scene& scene) {
    const CsvTable table = read_csv(path);
    check_columns(table, {"x", "y", "z", "nx", "ny", "nz"}, {});
    if (table.rows.empty())
        throw Error(fmt::format("{}:{}: no point follows the header", table.file, table.header.line));
    std::vector<ProbePoint> points;
    for (const CsvRow& row : table.rows) points.push_back(read_point(table, row, scene));
    return points;
}

std::string probe_text(const std::vector<ProbePoint>& points, const std::vector<Rgb>& irradiance) {
    assert(points.size() == irradiance.size());
    std::string text = "x,y,z,nx,ny,nz,red,green,blue,irradiance,lux\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
        const float weighted = luminance(irradiance[i]);
        text += fmt::format("{},{},{},{},{}\n", commas(number_texts(points[i].world)),
                            commas(number_texts(points[i].normal)), commas(number_texts(irradiance[i])),
                            number_text(weighted), number_text(kLumensPerWatt * weighted));
    }
    return text;
}

}  // namespace pim
