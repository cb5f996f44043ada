// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/density.h"

#include "bake/sample_photons.h"
#include "common/core/parallel.h"
#include "common/render/photon_tree.h"

namespace pim {
namespace {

constexpr uint64_t kChunk = uint64_t{1} << 19;  // photons summed by one thread, whatever the thread count
constexpr std::size_t kChunksAtOnce = 8;

// What a landing leaves in a patch, summed in double.
struct PatchSums {
    std::vector<Vec3d> flux;
    std::vector<double> squares;

    void resize(std::size_t n) { flux.assign(n, Vec3d(0)), squares.assign(n, 0); }
    void add(std::size_t patch, const Rgb& value) {
        flux[patch] += Vec3d(value);
        squares[patch] += double(mean_channel(value)) * double(mean_channel(value));
    }
    void add(const PatchSums& other) {
        for (std::size_t i = 0; i < flux.size(); ++i)
            flux[i] += other.flux[i], squares[i] += other.squares[i];
    }
};

// A landing as the `sphere` estimator keeps it.
struct StoredPhoton {
    Vec3 position;
    Rgb flux;
    FacingWeights facing;
    Component component;
};

struct Chunk {
    std::array<PatchSums, kComponentCount> sums;
    std::vector<StoredPhoton> photons;
    EnergyAccount account;
};

class Tracer {
  public:
    Tracer(const Scene& scene, const RayCaster& caster, const Cells& cells, const SurfaceCells& surface,
           const LightSample& sample)
        : scene_(scene), cells_(cells), surface_(surface), photons_(scene, caster, sample) {}

    Chunk trace(uint64_t begin, uint64_t end) const {
        Chunk chunk;
        if (scene_.grid.estimator == Estimator::area)
            for (const Component c : scene_.bake.components) chunk.sums[int(c)].resize(cells_.patches.size());
        const auto landed = [&](const Landing& landing) { deposit(landing, chunk); };
        photons_.trace(begin, end, landed, chunk.account);
        return chunk;
    }

  private:
    void deposit(const Landing& landing, Chunk& chunk) const {
        const Component component = landing.straight ? Component::direct : Component::indirect;
        if (std::ranges::find(scene_.bake.components, component) == scene_.bake.components.end()) return;
        const SurfacePoint& s = landing.surface;
        const auto flux = stored_flux(landing, scene_.bake.store);
        const auto cell = flux ? counted_cell(cells_, surface_, s) : std::nullopt;
        if (!cell) return;
        if (scene_.grid.estimator == Estimator::sphere)
            chunk.photons.push_back(
                {s.position, *flux, facing_weights(cells_.grid, s.shading_normal), component});
        else
            for_each_patch_at(cells_, *cell, s, [&](std::size_t patch, float share) {
                chunk.sums[int(component)].add(patch, *flux * share);
            });
    }

    const Scene& scene_;
    const Cells& cells_;
    const SurfaceCells& surface_;
    SamplePhotons photons_;
};

// E = flux / area, per emitted photon.
void densities_by_area(const Cells& cells, const PatchSums& sums, double photons,
                       DensityVolume::PerComponent& out) {
    for (std::size_t p = 0; p < cells.patches.size(); ++p) {
        const double scale = 1 / (photons * double(cells.patches[p].area));
        out.density.push_back(Rgb(sums.flux[p] * scale));
        out.variance.push_back(float(sums.squares[p] * scale * scale));
    }
}

// What lies within the sphere about a cell's centre, for one facing.
struct SphereSums {
    Vec3d flux{0};                 // sum of w · flux, w the photon's share of the facing
    double squares = 0;            // sum of (w · flux)², channels' mean
    double first = 0, second = 0;  // sums of w · flux and w² · flux, channels' mean

    void add(const Rgb& photon, double w) {
        const double mean = mean_channel(photon);
        flux += Vec3d(photon) * w;
        squares += w * mean * w * mean;
        first += w * mean, second += w * w * mean;
    }
    // Flux / (pi r²), as the thesis; a surface between facings shows each only the share `second / first` of
    // itself.
    double scale(double disk, double photons) const {
        return second > 0 ? first / (second * disk * photons) : 0;
    }
};

void densities_by_sphere(const Scene& scene, const Cells& cells, const std::vector<StoredPhoton>& photons,
                         DensityVolume& volume) {
    const double radius = scene.grid.radius.value_or(kDefaultRadius * cells.grid.cell_size);
    const double disk = double(kPi) * radius * radius, emitted = double(scene.bake.photons);
    std::vector<Vec3> positions;
    for (const StoredPhoton& photon : photons) positions.push_back(photon.position);
    const PhotonTree tree(positions);
    for (const Component c : scene.bake.components) {
        volume.components[int(c)].density.resize(cells.patches.size());
        volume.components[int(c)].variance.resize(cells.patches.size());
    }
    for (std::size_t p = 0; p < cells.patches.size(); ++p) {
        std::array<SphereSums, kComponentCount> sums;
        for (const std::size_t i : tree.within(cells.grid.centre(cells.patches[p].cell), radius))
            sums[int(photons[i].component)].add(
                photons[i].flux, photons[i].facing.weight[cells.patches[p].slot % kFacingCount]);
        for (const Component c : scene.bake.components) {
            const double scale = sums[int(c)].scale(disk, emitted);
            volume.components[int(c)].density[p] = Rgb(sums[int(c)].flux * scale);
            volume.components[int(c)].variance[p] = float(sums[int(c)].squares * scale * scale);
        }
    }
}

}  // namespace

std::optional<Index3> counted_cell(const Cells& cells, const SurfaceCells& surface, const SurfacePoint& s) {
    const auto fine = surface.fine_cell(s.triangle, s.side, s.position);
    if (!fine || !s.material->receives()) return std::nullopt;
    const Index3 cell = cell_of_fine(*fine);
    if (!cells.index.find_cell(cell)) return std::nullopt;
    if (cells.left_out.contains(fragment_key(cells.grid, s.triangle, s.side, *fine)))
        return std::nullopt;
    return cell;
}

std::optional<Rgb> stored_flux(const Landing& landing, Store store) {
    if (store == Store::incident) return landing.flux;
    return landing.ends ? std::optional(landing.flux / landing.chance_of_ending) : std::nullopt;
}

DensityVolume trace_density(const Scene& scene, const RayCaster& caster, const Cells& cells,
                            const SurfaceCells& surface, const LightSample& sample) {
    const Tracer tracer(scene, caster, cells, surface, sample);
    const uint64_t photons = scene.bake.photons, chunk_count = (photons + kChunk - 1) / kChunk;
    Chunk total;
    for (uint64_t first = 0; first < chunk_count; first += kChunksAtOnce) {
        std::vector<Chunk> chunks(std::min<uint64_t>(kChunksAtOnce, chunk_count - first));
        parallel_for(chunks.size(), [&](std::size_t i) {
            chunks[i] = tracer.trace((first + i) * kChunk, std::min(photons, (first + i + 1) * kChunk));
        });
        for (Chunk& chunk : chunks) {  // in order: the same sums at any thread count
            total.account.add(chunk.account);
            total.photons.insert(total.photons.end(), chunk.photons.begin(), chunk.photons.end());
            for (int c = 0; c < kComponentCount; ++c) {
                if (total.sums[c].flux.empty())
                    total.sums[c] = std::move(chunk.sums[c]);
                else
                    total.sums[c].add(chunk.sums[c]);
            }
        }
    }
    DensityVolume volume;
    volume.account = total.account;
    if (scene.grid.estimator == Estimator::sphere) {
        densities_by_sphere(scene, cells, total.photons, volume);
    } else {
        for (const Component c : scene.bake.components)
            densities_by_area(cells, total.sums[int(c)], double(photons), volume.components[int(c)]);
    }
    return volume;
}

}  // namespace pim
