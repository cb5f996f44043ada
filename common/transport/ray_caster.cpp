// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/transport/ray_caster.h"

#include <embree3/rtcore.h>
#include <fmt/format.h>

#include <cstddef>
#include <cstring>

#include "common/core/error.h"
#include "common/core/float_traps.h"

namespace pim {
namespace {

RTCRay to_embree(const Ray& ray) {
    RTCRay r{};
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tnear = 0;
    r.tfar = ray.length;
    r.mask = ~0u;
    return r;
}

}  // namespace

struct RayCaster::Implementation {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::string instructions;
    // Embree reads the last vertex with a 16-byte load: one extra element.
    std::vector<Vec3> positions;
    std::vector<std::array<uint32_t, 3>> indices;

    ~Implementation() {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
};

RayCaster::RayCaster(const Geometry& geometry, InstructionSet instructions)
    : implementation_(std::make_unique<Implementation>()) {
    Implementation& i = *implementation_;
    i.instructions = instructions == InstructionSet::pinned ? "sse4.2" : "best";
    i.device = rtcNewDevice(instructions == InstructionSet::pinned ? "isa=sse4.2" : nullptr);
    if (!i.device) throw Error("the ray tracing library cannot start on this processor (it needs SSE 4.2)");
    i.scene = rtcNewScene(i.device);
    rtcSetSceneFlags(i.scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(i.scene, RTC_BUILD_QUALITY_MEDIUM);
    i.positions = geometry.positions;
    i.positions.emplace_back(0);
    for (const Triangle& t : geometry.triangles) i.indices.push_back(t.vertices);
    RTCGeometry mesh = rtcNewGeometry(i.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, i.positions.data(), 0,
                               sizeof(Vec3), geometry.positions.size());
    rtcSetSharedGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, i.indices.data(), 0,
                               sizeof i.indices[0], i.indices.size());
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(i.scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(i.scene);
    if (const RTCError error = rtcGetDeviceError(i.device); error != RTC_ERROR_NONE)
        throw Error(fmt::format(
            "the ray tracing library failed to build its tree (error {}); is there enough memory?",
            int(error)));
    const Box3 box = bounds(geometry);
    float largest = 0;
    for (int axis = 0; axis < 3; ++axis)
        largest = std::max({largest, std::abs(box.min[axis]), std::abs(box.max[axis])});
    surface_offset_ = largest * 0x1p-20f;
}

RayCaster::~RayCaster() = default;

std::optional<Hit> RayCaster::intersect(const Ray& ray) const {
    RTCRayHit query{to_embree(ray), {}};
    query.hit.geomID = query.hit.primID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const FloatTraps library(FloatTraps::off);
    rtcIntersect1(implementation_->scene, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const Vec3 normal(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
    return Hit{query.hit.primID, query.ray.tfar, query.hit.u, query.hit.v,
               normal.dot(ray.direction) <= 0 ? Side::front : Side::back};
}

bool RayCaster::occluded(const Ray& ray) const {
    RTCRay query = to_embree(ray);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    const FloatTraps library(FloatTraps::off);
    rtcOccluded1(implementation_->scene, &context, &query);
    return query.tfar < 0;
}

namespace {

static_assert(sizeof(RayPacket) == sizeof(RTCRay16) && sizeof(HitPacket) == sizeof(RTCRayHit16));
static_assert(offsetof(RayPacket, length) == offsetof(RTCRay16, tfar));
static_assert(offsetof(HitPacket, triangle) == offsetof(RTCRayHit16, hit.primID));

struct ActiveLanes {
    alignas(64) int valid[RayPacket::kSize];
    explicit ActiveLanes(const RayPacket& packet) {
        for (int lane = 0; lane < RayPacket::kSize; ++lane) valid[lane] = packet.length[lane] >= 0 ? -1 : 0;
    }
};

RTCIntersectContext coherent() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}

}  // namespace

RayPacket::RayPacket() {
    std::memset(this, 0, sizeof *this);
    std::fill_n(mask, kSize, ~0u);
    std::fill_n(length, kSize, -1.0f);
}

std::optional<Hit> HitPacket::hit(int lane) const {
    static_assert(RTC_INVALID_GEOMETRY_ID == ~0u);
    if (!is_hit(lane)) return std::nullopt;
    float towards = 0;
    for (int axis = 0; axis < 3; ++axis) towards += normal[axis][lane] * rays.direction[axis][lane];
    return Hit{triangle[lane], rays.length[lane], u[lane], v[lane], towards <= 0 ? Side::front : Side::back};
}

void RayCaster::intersect(HitPacket& packet) const {
    const ActiveLanes active(packet.rays);
    std::fill_n(packet.geometry, RayPacket::kSize, RTC_INVALID_GEOMETRY_ID);
    RTCIntersectContext context = coherent();
    const FloatTraps library(FloatTraps::off);
    rtcIntersect16(active.valid, implementation_->scene, &context, reinterpret_cast<RTCRayHit16*>(&packet));
}

void RayCaster::occluded(RayPacket& packet) const {
    const ActiveLanes active(packet);
    RTCIntersectContext context = coherent();
    const FloatTraps library(FloatTraps::off);
    rtcOccluded16(active.valid, implementation_->scene, &context, reinterpret_cast<RTCRay16*>(&packet));
}

std::string RayCaster::instruction_set() const { return implementation_->instructions; }

}  // namespace pim
