// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/photon_map.h"

#include <CGAL/Fuzzy_sphere.h>
#include <CGAL/Kd_tree.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Search_traits_adapter.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/property_map.h>

namespace pim {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Entry = std::pair<Kernel::Point_3, std::size_t>;
using Traits = CGAL::Search_traits_adapter<Entry, CGAL::First_of_pair_property_map<Entry>,
                                           CGAL::Search_traits_3<Kernel>>;
using Tree = CGAL::Kd_tree<Traits>;

}  // namespace

struct PhotonMap::Implementation {
    Tree tree;
};

PhotonMap::PhotonMap(const std::vector<Vec3>& positions)
    : implementation_(std::make_unique<Implementation>()) {
    std::vector<Entry> entries;
    entries.reserve(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i)
        entries.emplace_back(Kernel::Point_3(positions[i].x, positions[i].y, positions[i].z), i);
    implementation_->tree.insert(entries.begin(), entries.end());
    if (!entries.empty()) implementation_->tree.build();
}

PhotonMap::~PhotonMap() = default;

std::vector<std::size_t> PhotonMap::within(const Vec3d& centre, double radius) const {
    std::vector<Entry> found;
    if (!implementation_->tree.empty())
        implementation_->tree.search(
            std::back_inserter(found),
            CGAL::Fuzzy_sphere<Traits>(Kernel::Point_3(centre.x, centre.y, centre.z), radius));
    std::vector<std::size_t> numbers;
    for (const Entry& e : found) numbers.push_back(e.second);
    std::ranges::sort(numbers);
    return numbers;
}

}  // namespace pim
