// SPDX-License-Identifier: GPL-3.0-or-later
// Included by one file per vector unit, inside a namespace of its own. No other header may be included
// here: inline functions compiled for a wide unit must not be shared with the rest of the program.

typedef float Lanes __attribute__((vector_size(4 * kLanes)));
typedef int32_t LanesInt __attribute__((vector_size(4 * kLanes)));
typedef Weight LanesWeight __attribute__((vector_size(sizeof(Weight) * kLanes)));

#define PIM_INLINE static inline __attribute__((always_inline))

PIM_INLINE const Lanes& at(const float* p) { return *reinterpret_cast<const Lanes*>(p); }
PIM_INLINE Lanes& at(float* p) { return *reinterpret_cast<Lanes*>(p); }
PIM_INLINE Lanes all(float v) { return v - Lanes{}; }
PIM_INLINE Lanes larger(const Lanes& a, const Lanes& b) { return a > b ? a : b; }
PIM_INLINE Lanes smaller(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
PIM_INLINE Lanes absolute(const Lanes& a) { return a < 0 ? -a : a; }
PIM_INLINE Lanes root(const Lanes& a) {
    Lanes r;
    for (int i = 0; i < kLanes; ++i) r[i] = __builtin_sqrtf(a[i]);
    return r;
}

static void evaluate(const float* coefficients, int terms, int channels, const float* monomials,
                     const float* power, float* sum) {
    if (channels == 1) {
        Lanes value{};
        for (int t = 0; t < terms; ++t) value += at(coefficients + t * kLanes) * monomials[t];
        for (int c = 0; c < 3; ++c) at(sum + c * kLanes) += value * power[c];
        return;
    }
    Lanes r{}, g{}, b{};
    for (int t = 0; t < terms; ++t, coefficients += 3 * kLanes) {
        r += at(coefficients) * monomials[t];
        g += at(coefficients + kLanes) * monomials[t];
        b += at(coefficients + 2 * kLanes) * monomials[t];
    }
    at(sum) += r * power[0];
    at(sum + kLanes) += g * power[1];
    at(sum + 2 * kLanes) += b * power[2];
}

// 1 up to a quarter of a cell from the tangent plane, 1e-4 from three quarters on, smooth between.
PIM_INLINE Lanes plane_factor(const Lanes& distance) {
    const Lanes t = larger(smaller((0.75f - absolute(distance)) * 2, all(1)), all(0));
    return larger(t * t * (3 - 2 * t), all(1e-4f));
}

struct Place {
    Lanes x, y, z, nx, ny, nz;
};

PIM_INLINE Lanes trilinear(const StencilEntry& e, const Place& p) {
    const Lanes x = e.step[0] > 0 ? p.x : 1 - p.x, y = e.step[1] > 0 ? p.y : 1 - p.y,
                z = e.step[2] > 0 ? p.z : 1 - p.z;
    return x * y * z;
}

PIM_INLINE Lanes plane_distance(const StencilEntry& e, const Place& p) {
    return p.nx * (e.centre[0] - p.x) + p.ny * (e.centre[1] - p.y) + p.nz * (e.centre[2] - p.z);
}

PIM_INLINE Lanes facing_weight(int axis, float threshold, const Place& p) {
    if (axis < 0) return all(1);
    const Lanes& n = axis == 0 ? p.nx : axis == 1 ? p.ny : p.nz;
    return larger(n * n - threshold, all(0));
}

PIM_INLINE Lanes seen_factor(const StencilEntry& e, const float* places) {
    const LanesInt unseen = __builtin_convertvector(at(places + (6 + e.axis) * kLanes), LanesInt);
    return (unseen >> e.bit & 1) != 0 ? all(kUnseenWeight) : all(1);
}

PIM_INLINE bool any_unseen(const float* places) {
    const Lanes sum = at(places + 6 * kLanes) + at(places + 7 * kLanes) + at(places + 8 * kLanes);
    float most = 0;
    for (int i = 0; i < kLanes; ++i) most += sum[i];
    return most > 0;
}

static void weigh(const StencilEntry* entries, int count, float threshold, const float* places,
                  float* weights) {
    const Place p{at(places),
                  at(places + kLanes),
                  at(places + 2 * kLanes),
                  at(places + 3 * kLanes),
                  at(places + 4 * kLanes),
                  at(places + 5 * kLanes)};
    Lanes area{}, total{};
    int first = 0;
    const bool some_unseen = any_unseen(places);
    for (int e = 0; e < count; ++e) {
        const Lanes t = trilinear(entries[e], p), d = plane_distance(entries[e], p);
        Lanes w = t * entries[e].area * plane_factor(d);
        if (some_unseen) w *= seen_factor(entries[e], places);
        if (entries[e].is_paired) {  // of two layers the nearer counts
            const Lanes behind = plane_distance(entries[e + 1], p);
            const Lanes a = d * d + 1e-6f, b = behind * behind + 1e-6f;
            at(weights + e * kLanes) = w * (b / (a + b));
            area += at(weights + e * kLanes);
            ++e;
            w = t * entries[e].area * plane_factor(behind) * (a / (a + b));
            if (some_unseen) w *= seen_factor(entries[e], places);
        }
        at(weights + e * kLanes) = w;
        area += w;
        if (!entries[e].ends_facing) continue;
        const Lanes facing = facing_weight(entries[e].axis, threshold, p);
        const Lanes scale = area > 0 ? facing / area : all(0);
        for (; first <= e; ++first) at(weights + first * kLanes) *= scale;
        total += area > 0 ? facing : all(0);
        area = all(0);
    }
    const Lanes scale = total > 0 ? 1 / total : all(0);
    for (int e = 0; e < count; ++e) at(weights + e * kLanes) *= scale;
}

// Transposes the rows of sixteen triangles.
PIM_INLINE void pick(const float* base, const uint32_t* triangle, int rows, Lanes* out) {
    for (int i = 0; i < kLanes; ++i) {
        const float* from = base + uint64_t(triangle[i]) * kTriangleRow;
        for (int row = 0; row < rows; ++row) reinterpret_cast<float*>(out + row)[i] = from[row];
    }
}

PIM_INLINE LanesInt floor_of(const Lanes& x) {
    const LanesInt truncated = __builtin_convertvector(x, LanesInt);
    return truncated + (x < __builtin_convertvector(truncated, Lanes));  // true is -1
}

static void locate(const TriangleRow* triangles, const HitLanes& hits, const GridPlacement& grid, float* rows,
                   int32_t* cells) {
    constexpr int kUsed = 21;
    Lanes t[kUsed];
    pick(triangles->corner, hits.triangle, kUsed, t);
    const Lanes &u = at(hits.u), &v = at(hits.v);
    Lanes towards{};
    for (int axis = 0; axis < 3; ++axis) towards += at(hits.normal[axis]) * at(hits.direction[axis]);
    const Lanes side = towards <= 0 ? all(1) : all(-1);
    Lanes geometric[3], bent[3], square{}, agreement{};
    for (int axis = 0; axis < 3; ++axis) {
        const Lanes position = t[axis] + t[3 + axis] * u + t[6 + axis] * v;
        geometric[axis] = t[9 + axis] * side;
        bent[axis] = (t[12 + axis] + t[15 + axis] * u + t[18 + axis] * v) * side;
        square += bent[axis] * bent[axis];
        agreement += bent[axis] * geometric[axis];
        at(rows + axis * kLanes) = position;
        at(rows + (6 + axis) * kLanes) = geometric[axis];
        const Lanes place = (position - grid.origin[axis]) * grid.cells_per_metre - 0.5f;
        const LanesInt low = floor_of(larger(smaller(place, all(1e6f)), all(-1e6f)));
        *reinterpret_cast<LanesInt*>(cells + axis * kLanes) = low;
        at(rows + (9 + axis) * kLanes) = place - __builtin_convertvector(low, Lanes);
    }
    const Lanes usable = (square > 0) & (agreement != 0) ? all(1) : all(0);
    const Lanes scale = (agreement > 0 ? all(1) : all(-1)) / root(usable > 0 ? square : all(1));
    LanesInt mask{}, home{};
    for (int axis = 0; axis < 3; ++axis) {
        const Lanes normal = usable > 0 ? bent[axis] * scale : geometric[axis];
        at(rows + (3 + axis) * kLanes) = normal;
        const LanesInt counts = -(normal * normal > grid.facing_threshold);
        const Lanes from_corner = at(rows + (9 + axis) * kLanes) + 0.5f + 0.01f * normal;  // as home_of
        const LanesInt upper = -(from_corner >= 1);
        const LanesInt odd = upper != 0 ? -(from_corner >= 1.25f) : -(from_corner >= 0.75f);
        home |= upper << axis | odd << (3 + axis);
        mask |= (normal < 0 ? counts << (2 * axis + 1) : counts << (2 * axis));
    }
    *reinterpret_cast<LanesInt*>(cells + 4 * kLanes) = home;
    *reinterpret_cast<LanesInt*>(cells + 3 * kLanes) = grid.facings ? mask : LanesInt{} + 1;
}

static void pack(const float* weights, int entries, Weight* packed) {
    Lanes rest{};
    for (int e = 0; e < entries; ++e, weights += kLanes, packed += kLanes) {
        const Lanes wanted = at(weights) * kWeightSteps + rest, nothing{};
        const LanesInt steps = __builtin_convertvector(at(weights) > 0 ? wanted + 0.5f : nothing, LanesInt);
        rest = wanted - __builtin_convertvector(steps, Lanes);
        *reinterpret_cast<LanesWeight*>(packed) = __builtin_convertvector(steps, LanesWeight);
    }
}

static void gather(const Weight* weights, const float* values, int entries, float* sum) {
    Lanes r{}, g{}, b{};
    for (int e = 0; e < entries; ++e, values += 3) {
        const Lanes w = __builtin_convertvector(
            __builtin_convertvector(*reinterpret_cast<const LanesWeight*>(weights + e * kLanes), LanesInt),
            Lanes);
        r += w * values[0];
        g += w * values[1];
        b += w * values[2];
    }
    at(sum) = r * (1 / kWeightSteps);
    at(sum + kLanes) = g * (1 / kWeightSteps);
    at(sum + 2 * kLanes) = b * (1 / kWeightSteps);
}

static void aim(const float* s, const float* targets, const float* lamp_normal, float offset,
                const ShadowRays& rays) {
    const Lanes px = at(s), py = at(s + kLanes), pz = at(s + 2 * kLanes);
    const Lanes &tx = at(targets), &ty = at(targets + kLanes), &tz = at(targets + 2 * kLanes);
    const Lanes x = tx - px, y = ty - py, z = tz - pz;
    const Lanes square = x * x + y * y + z * z;
    const Lanes &nx = at(s + 3 * kLanes), &ny = at(s + 4 * kLanes), &nz = at(s + 5 * kLanes);
    const Lanes &gx = at(s + 6 * kLanes), &gy = at(s + 7 * kLanes), &gz = at(s + 8 * kLanes);
    const Lanes cosine = x * nx + y * ny + z * nz, geometric = x * gx + y * gy + z * gz;
    Lanes term = cosine / (square * root(square));
    if (lamp_normal) {
        const Lanes lamp = -(x * lamp_normal[0] + y * lamp_normal[1] + z * lamp_normal[2]) / root(square);
        term *= larger(lamp, all(0));
    }
    at(rays.term) = (cosine > 0) & (geometric > 0) & (square > 0) ? term : all(0);
    const Lanes ox = px + gx * offset, oy = py + gy * offset, oz = pz + gz * offset;
    at(rays.origin[0]) = ox, at(rays.origin[1]) = oy, at(rays.origin[2]) = oz;
    at(rays.direction[0]) = tx - ox, at(rays.direction[1]) = ty - oy, at(rays.direction[2]) = tz - oz;
}

PIM_INLINE Lanes curve_of(int curve, const Lanes& exposed) {
    const Lanes x = smaller(exposed > 0 ? exposed : all(0), all(1e9f));  // also what is no number
    if (curve == 1) return x / (1 + x);
    if (curve == 2) return smaller(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), all(1));
    return smaller(x, all(1));
}

// sRGB (IEC 61966-2-1); above its linear part a polynomial in the fourth root, off by less than 1e-5, a
// four-hundredth of an 8-bit step.
PIM_INLINE LanesInt encoded(const Lanes& x) {
    const Lanes q = root(root(x));
    const Lanes upper =
        ((((-0.062758992f * q + 0.27275224f) * q - 0.55755565f) * q + 1.244214f) * q + 0.164974f) * q -
        0.061629706f;
    const Lanes e = x <= 0.0031308f ? 12.92f * x : upper;
    return __builtin_convertvector(e * 255 + 0.5f, LanesInt);
}

static void encode(const float* linear, float exposure, int curve, uint32_t* rgba) {
    const LanesInt r = encoded(curve_of(curve, at(linear) * exposure)),
                   g = encoded(curve_of(curve, at(linear + kLanes) * exposure)),
                   b = encoded(curve_of(curve, at(linear + 2 * kLanes) * exposure));
    *reinterpret_cast<LanesInt*>(rgba) = r | g << 8 | b << 16 | int32_t(0xff000000u);
}

extern const Kernels kKernels;
const Kernels kKernels{evaluate, locate, weigh, pack, gather, aim, encode};
