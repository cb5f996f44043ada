// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "common/core/error.h"
#include "viewer/files/csv.h"

namespace pim {
namespace {

constexpr CsvRange kTimes{0, 1e9}, kGains{0, 1e30}, kFovs{0.1, 179};

// Of the two neighbouring keys that `time` falls between, the place of the second. At least two keys.
template <class AnyKey>
std::size_t key_after(const std::vector<AnyKey>& keys, double time) {
    const auto first = keys.begin() + 1, last = keys.end() - 1;
    const auto after = std::partition_point(first, last, [&](const AnyKey& k) { return k.time < time; });
    return std::size_t(after - keys.begin());
}

double linear(const std::vector<Key>& keys, double time) {
    if (time <= keys.front().time) return keys.front().value;
    if (time >= keys.back().time) return keys.back().value;
    const std::size_t k = key_after(keys, time);
    const Key &a = keys[k - 1], &b = keys[k];
    return std::lerp(a.value, b.value, (time - a.time) / (b.time - a.time));
}

// From key k to key k + 1, per second.
Vec3d slope(const std::vector<CameraKey>& keys, Vec3 CameraKey::*point, std::size_t k) {
    return (Vec3d(keys[k + 1].*point) - Vec3d(keys[k].*point)) / (keys[k + 1].time - keys[k].time);
}

// Velocity at key k: of the parabola through it and its neighbours; at an end, of the one next to it.
Vec3d tangent(const std::vector<CameraKey>& keys, Vec3 CameraKey::*point, std::size_t k) {
    const std::size_t last = keys.size() - 1;
    if (last == 1) return slope(keys, point, 0);
    if (k == 0) return slope(keys, point, 0) * 2.0 - tangent(keys, point, 1);
    if (k == last) return slope(keys, point, last - 1) * 2.0 - tangent(keys, point, last - 1);
    const double before = keys[k].time - keys[k - 1].time, after = keys[k + 1].time - keys[k].time;
    return (slope(keys, point, k - 1) * after + slope(keys, point, k) * before) / (before + after);
}

// Cubic Hermite curve with those tangents.
Vec3 smooth(const std::vector<CameraKey>& keys, Vec3 CameraKey::*point, double time) {
    if (time <= keys.front().time) return keys.front().*point;
    if (time >= keys.back().time) return keys.back().*point;
    const std::size_t k = key_after(keys, time);
    const double length = keys[k].time - keys[k - 1].time, s = (time - keys[k - 1].time) / length;
    const Vec3d a(keys[k - 1].*point), b(keys[k].*point);
    const Vec3d out = tangent(keys, point, k - 1) * length, in = tangent(keys, point, k) * length;
    const double s2 = s * s, s3 = s2 * s;
    return Vec3(a * (2 * s3 - 3 * s2 + 1) + out * (s3 - 2 * s2 + s) + b * (3 * s2 - 2 * s3) + in * (s3 - s2));
}

// A camera that flies over its target, or through it, still has to look somewhere.
void keep_upright(Camera& camera, const Vec3& earlier_direction) {
    if (camera.target == camera.eye) camera.target = camera.eye + earlier_direction;
    const Vec3 direction = camera.target - camera.eye;
    if (direction.cross(camera.up).length() > 0) return;
    camera.up = std::abs(direction.y) < 0.9f * direction.length() ? Vec3(0, 1, 0) : Vec3(0, 0, 1);
}

void move_camera(const Animation& animation, double time, Camera& camera) {
    const std::vector<CameraKey>& keys = animation.camera;
    if (!animation.fov.empty()) camera.vertical_fov = float(linear(animation.fov, time));
    if (keys.empty()) return;
    camera.eye = smooth(keys, &CameraKey::eye, time);
    camera.target = smooth(keys, &CameraKey::target, time);
    const CameraKey& earlier = keys[keys.size() == 1 ? 0 : key_after(keys, time) - 1];
    keep_upright(camera, earlier.target - earlier.eye);
}

void move_lamp(const LampPath& path, double time, LampControl& lamp) {
    for (int axis = 0; axis < 3; ++axis) {
        if (path.position[axis].empty()) continue;
        const float value = float(linear(path.position[axis], time));
        lamp.position[axis] = std::clamp(value, path.domain.min[axis], path.domain.max[axis]);
    }
    if (!path.gain.empty()) lamp.gain = float(linear(path.gain, time));
}

class PathReader {
  public:
    PathReader(const Scene& scene, Animation& animation) : scene_(scene), animation_(animation) {}

    void read(const std::filesystem::path& path) {
        const CsvTable table = read_csv(path);
        const bool lamps = table.has("lamp"), camera = table.has("eye_x");
        if (lamps == camera)
            throw Error(
                fmt::format("{}:{}: the columns must be time,lamp,x,y,z,gain of lamps, or time,eye_x,eye_y,"
                            "eye_z,target_x,target_y,target_z,fov of the camera",
                            table.file, table.header.line));
        if (table.rows.empty())
            throw Error(fmt::format("{}:{}: no key follows the header", table.file, table.header.line));
        lamps ? read_lamps(table) : read_camera(table);
    }

  private:
    void read_lamps(const CsvTable& table) {
        check_columns(table, {"time", "lamp"}, {"x", "y", "z", "gain"});
        const std::size_t known = animation_.lamps.size();  // from earlier files
        for (const CsvRow& row : table.rows) {
            const std::size_t l = lamp_of(table, row), place = place_of(l);
            if (place < known) fail(table, row, "lamp", "another file moves this lamp already");
            read_lamp_key(table, row, animation_.lamps[place]);
        }
    }

    std::size_t lamp_of(const CsvTable& table, const CsvRow& row) const {
        try {
            return find_light(scene_, csv_text(table, row, "lamp"));
        } catch (const UsageError& e) {
            fail(table, row, "lamp", e.what());
        }
    }

    std::size_t place_of(std::size_t lamp) {
        auto& paths = animation_.lamps;
        const auto found = std::ranges::find(paths, lamp, &LampPath::lamp);
        const auto place = std::size_t(found - paths.begin());
        if (found == paths.end()) paths.push_back({lamp, scene_.lights[lamp].domain, {}, {}});
        return place;
    }

    void read_lamp_key(const CsvTable& table, const CsvRow& row, LampPath& path) const {
        const double time = later_time(table, row, path.last_time);
        path.last_time = time;
        Vec3 position = scene_.lights[path.lamp].position;
        const char* const columns[] = {"x", "y", "z"};
        std::string moved;
        for (int axis = 0; axis < 3; ++axis)
            if (const auto world = csv_optional_number(table, row, columns[axis])) {
                position[axis] = float(*world - scene_.geometry.origin[axis]);
                path.position[axis].push_back({time, position[axis]});
                if (!moved.empty()) moved += ',';
                moved += columns[axis];
            }
        check_position(table, row, moved, path, position);
        if (const auto gain = csv_optional_number(table, row, "gain", kGains))
            path.gain.push_back({time, *gain});
    }

    void check_position(const CsvTable& table, const CsvRow& row, const std::string& moved,
                        const LampPath& path, const Vec3& position) const {
        try {
            if (!moved.empty())
                check_in_domain(scene_.lights[path.lamp].name, path.domain, position, scene_.geometry.origin);
        } catch (const UsageError& e) {
            fail(table, row, moved, e.what());
        }
    }

    void read_camera(const CsvTable& table) {
        check_columns(table, {"time", "eye_x", "eye_y", "eye_z", "target_x", "target_y", "target_z"},
                      {"fov"});
        if (!animation_.camera.empty())
            throw Error(
                fmt::format("{}:{}: another file moves the camera already", table.file, table.header.line));
        for (const CsvRow& row : table.rows) read_camera_key(table, row);
    }

    void read_camera_key(const CsvTable& table, const CsvRow& row) {
        const auto point = [&](const std::string& name) {
            return scene_.geometry.to_local({csv_number(table, row, name + "_x"),
                                             csv_number(table, row, name + "_y"),
                                             csv_number(table, row, name + "_z")});
        };
        const double earlier = animation_.camera.empty() ? -1 : animation_.camera.back().time;
        const double time = later_time(table, row, earlier);
        const CameraKey key{time, point("eye"), point("target")};
        if (key.eye == key.target) fail(table, row, "target_x", "eye and target must not be the same point");
        animation_.camera.push_back(key);
        if (const auto fov = csv_optional_number(table, row, "fov", kFovs))
            animation_.fov.push_back({time, *fov});
    }

    static double later_time(const CsvTable& table, const CsvRow& row, double earlier) {
        const double time = csv_number(table, row, "time", kTimes);
        if (time <= earlier)
            fail(table, row, "time",
                 fmt::format("{} does not come after {}; times must increase", time, earlier));
        return time;
    }

    const Scene& scene_;
    Animation& animation_;
};

}  // namespace

ViewState Animation::at(double time, const ViewState& base) const {
    ViewState state = base;
    for (const LampPath& path : lamps) move_lamp(path, time, state.lamps[path.lamp]);
    move_camera(*this, time, state.camera);
    return state;
}

double Animation::duration() const {
    double last = camera.empty() ? 0 : camera.back().time;
    for (const LampPath& path : lamps) last = std::max(last, path.last_time);
    return last;
}

int Animation::frame_count(double fps) const {
    constexpr double kMost = 1e6, kRounding = 1e-9;  // 2.3 s at 100/s is 229.99... frames
    if (!(fps > 0)) throw UsageError(fmt::format("frames per second: {} must be above 0", fps));
    const double frames = std::floor(duration() * fps + kRounding) + 1;
    if (!(frames <= kMost))
        throw UsageError(fmt::format("{} s at {} frames per second are {} frames; allowed: up to {}",
                                     duration(), fps, frames, kMost));
    return int(frames);
}

Animation read_animation(const std::vector<std::filesystem::path>& paths, const Scene& scene) {
    Animation animation;
    PathReader reader(scene, animation);
    for (const std::filesystem::path& path : paths) reader.read(path);
    return animation;
}

}  // namespace pim
