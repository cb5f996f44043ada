// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/animation.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/core/error.h"
#include "temporary_folder.h"
#include "test_scenes.h"
#include "viewer/files/frames.h"

namespace pim {
namespace {

const std::string kCamera = "time,eye_x,eye_y,eye_z,target_x,target_y,target_z";

// A room about the world's point (10, 20, 30), two lamps that roam it.
class AnimationTest : public testing::Test {
  protected:
    AnimationTest() : scene_(room(Rgb(0.5f), Vec3(4))) {
        scene_.geometry.origin = {10, 20, 30};
        scene_.lights[0].domain = Box3(Vec3(0.5f), Vec3(3.5f));
        scene_.lights[0].position = Vec3(1);
        scene_.lights.push_back(scene_.lights[0]);
        scene_.lights[1].name = "other";
        scene_.cameras = {{.name = "front", .eye = {2, 2, 3}, .target = {2, 2, 0}}};
        base_ = initial_state(scene_, {});
        base_.lamps[0].gain = 5;
    }
    Animation read(const std::string& text) const {
        return read_animation({folder_.write("path.csv", text)}, scene_);
    }
    Animation read(const std::string& first, const std::string& second) const {
        return read_animation({folder_.write("a.csv", first), folder_.write("b.csv", second)}, scene_);
    }
    void expect_error(const std::string& text, const std::vector<std::string>& parts) const {
        const std::string message = message_of<Error>([&] { read(text); });
        for (const std::string& part : parts)
            EXPECT_NE(message.find(part), std::string::npos) << part << " in: " << message << "\n" << text;
        EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
    Scene scene_;
    ViewState base_;
    TemporaryFolder folder_;
};

TEST_F(AnimationTest, LampsGoStraightAndWaitAtTheEnds) {
    const Animation path = read("time,lamp,x,y,z,gain\n1,lamp,11,21,31,0\n3,lamp,13,22,31,4\n");
    EXPECT_EQ(path.at(0, base_).lamps[0].position, Vec3(1, 1, 1));
    EXPECT_EQ(path.at(0, base_).lamps[0].gain, 0);
    EXPECT_EQ(path.at(1.5, base_).lamps[0].position, Vec3(1.5f, 1.25f, 1));
    EXPECT_EQ(path.at(1.5, base_).lamps[0].gain, 1);
    EXPECT_EQ(path.at(3, base_).lamps[0].position, Vec3(3, 2, 1));
    EXPECT_EQ(path.at(9, base_).lamps[0].position, Vec3(3, 2, 1));
    EXPECT_EQ(path.at(9, base_).lamps[0].gain, 4);
    EXPECT_EQ(path.at(9, base_).lamps[1].position, base_.lamps[1].position);
    EXPECT_EQ(path.at(9, base_).camera.eye, base_.camera.eye);
    EXPECT_EQ(path.duration(), 3);
}

TEST_F(AnimationTest, EmptyValuesComeFromTheOtherKeysOrTheState) {
    const Animation path =
        read("time,lamp,x,y,z,gain\n0,lamp,11,,31,\n0,other,,,,2\n1,lamp,,,33,\n4,lamp,13,,,\n5,lamp,,,,\n");
    const ViewState state = path.at(2, base_);
    EXPECT_EQ(state.lamps[0].position, Vec3(2, base_.lamps[0].position.y, 3));
    EXPECT_EQ(state.lamps[0].gain, 5);
    EXPECT_EQ(state.lamps[1].gain, 2);
    EXPECT_EQ(path.duration(), 5);
}

TEST_F(AnimationTest, ColumnsInAnyOrderAndOnlyThoseNeeded) {
    const Animation path = read("gain,lamp,time\n1,lamp,0\n3,lamp,2\n");
    EXPECT_EQ(path.at(1, base_).lamps[0].gain, 2);
    EXPECT_EQ(path.at(1, base_).lamps[0].position, base_.lamps[0].position);
}

TEST_F(AnimationTest, LampsStayInTheirDomains) {
    const Animation path = read("time,lamp,x\n0,lamp,10.49999\n1,lamp,13.5\n");  // forgiven as rounding
    EXPECT_EQ(path.at(0, base_).lamps[0].position.x, 0.5f);
    EXPECT_EQ(path.at(1, base_).lamps[0].position.x, 3.5f);
}

// With tangents of parabolas, a path whose keys lie on one follows it at any times.
TEST_F(AnimationTest, CameraFollowsAParabolaThroughUnevenKeys) {
    const auto eye = [](double t) { return Vec3d(1 + 2 * t, 3 - t + 0.5 * t * t, -t * t); };
    const auto target = [](double t) { return Vec3d(2 * t * t, 8, 1 + t); };
    std::string text = kCamera + "\n";
    for (const double t : {0.5, 0.75, 2.0, 4.5}) {
        const Vec3d e = scene_.geometry.origin + eye(t), g = scene_.geometry.origin + target(t);
        text += fmt::format("{},{},{},{},{},{},{}\n", t, e.x, e.y, e.z, g.x, g.y, g.z);
    }
    const Animation path = read(text);
    for (double t = 0.5; t <= 4.5; t += 0.03125) {
        const Camera camera = path.at(t, base_).camera;
        EXPECT_LT((Vec3d(camera.eye) - eye(t)).length(), 1e-5) << t;
        EXPECT_LT((Vec3d(camera.target) - target(t)).length(), 1e-5) << t;
    }
    EXPECT_EQ(path.at(0, base_).camera.eye, Vec3(eye(0.5)));
    EXPECT_EQ(path.at(7, base_).camera.target, Vec3(target(4.5)));
    EXPECT_EQ(path.at(1, base_).camera.up, base_.camera.up);
}

// At even times: Catmull and Rom's (-p0 + 9 p1 + 9 p2 - p3) / 16 in the middle.
TEST_F(AnimationTest, CameraIsACatmullRomCurve) {
    const Animation path = read(
        kCamera + "\n0,10,20,31,10,20,30\n1,11,20,31,10,20,30\n2,11,25,31,10,20,30\n3,13,20,31,10,20,30\n");
    const Vec3 eye = path.at(1.5, base_).camera.eye;
    EXPECT_FLOAT_EQ(eye.x, (-0 + 9 * 1 + 9 * 1 - 3) / 16.0f);
    EXPECT_FLOAT_EQ(eye.y, (-0 + 9 * 0 + 9 * 5 - 0) / 16.0f);
    EXPECT_FLOAT_EQ(eye.z, 1);
}

TEST_F(AnimationTest, CameraKeepsItsVelocityAcrossKeys) {
    const Animation path = read(kCamera +
                                "\n0,10,20,31,10,20,30\n0.5,14,20,33,10,20,30\n2,11,25,31,10,20,30\n2.25,"
                                "13,20,31,10,20,30\n");
    const double step = 1e-3;
    for (const double t : {0.5, 2.0}) {
        const auto eye = [&](double time) { return Vec3d(path.at(time, base_).camera.eye); };
        const Vec3d before = (eye(t) - eye(t - step)) / step, after = (eye(t + step) - eye(t)) / step;
        EXPECT_LT((before - after).length(), 0.15) << t;
        EXPECT_GT(before.length(), 1) << t;
    }
}

TEST_F(AnimationTest, OneAndTwoCameraKeys) {
    const Animation one = read(kCamera + ",fov\n2,12,20,31,10,20,30,50\n");
    EXPECT_EQ(one.at(0, base_).camera.eye, Vec3(2, 0, 1));
    EXPECT_EQ(one.at(5, base_).camera.vertical_fov, 50);
    EXPECT_EQ(one.duration(), 2);
    const Animation two = read(kCamera + ",fov\n0,10,20,31,10,20,30,\n2,12,20,31,10,20,30,\n");
    EXPECT_EQ(two.at(0.5, base_).camera.eye, Vec3(0.5f, 0, 1));
    EXPECT_EQ(two.at(0.5, base_).camera.vertical_fov, base_.camera.vertical_fov);
}

TEST_F(AnimationTest, FieldOfViewGoesStraight) {
    const Animation path =
        read(kCamera + ",fov\n0,10,20,31,10,20,30,30\n1,11,20,31,10,20,30,\n4,12,20,31,10,20,30,50\n");
    EXPECT_EQ(path.at(1, base_).camera.vertical_fov, 35);
}

TEST_F(AnimationTest, CameraAlwaysLooksSomewhere) {
    const Animation down = read(kCamera + "\n0,10,25,30,10,20,30\n");
    const Camera above = down.at(0, base_).camera;
    EXPECT_GT((above.target - above.eye).cross(above.up).length(), 0);
    const Animation through = read(kCamera + "\n0,10,20,30,12,20,30\n2,14,20,30,12,20,30\n");
    const Camera inside = through.at(1, base_).camera;
    EXPECT_GT((inside.target - inside.eye).cross(inside.up).length(), 0);
}

TEST_F(AnimationTest, TwoFilesMoveLampsAndCamera) {
    const std::string lamps = "time,lamp,gain\n0,lamp,1\n2,lamp,3\n";
    const std::string camera = kCamera + "\n0,10,20,31,10,20,30\n5,12,20,31,10,20,30\n";
    const Animation path = read(lamps, camera);
    EXPECT_EQ(path.at(1, base_).lamps[0].gain, 2);
    EXPECT_FLOAT_EQ(path.at(2.5, base_).camera.eye.x, 1);
    EXPECT_EQ(path.duration(), 5);
    EXPECT_NE(message_of<Error>([&] { read(camera, camera); }).find("b.csv:1: another file"),
              std::string::npos);
    EXPECT_NE(message_of<Error>([&] { read(lamps, lamps); }).find("b.csv:2: lamp: another file"),
              std::string::npos);
    EXPECT_EQ(read(lamps, "time,lamp,gain\n0,other,1\n").lamps.size(), 2u);
}

TEST_F(AnimationTest, FrameCount) {
    const auto frames = [&](const std::string& end, double fps) {
        return read("time,lamp,gain\n0,lamp,1\n" + end + ",lamp,1\n").frame_count(fps);
    };
    EXPECT_EQ(frames("2", 25), 51);
    EXPECT_EQ(frames("2.3", 100), 231);  // 2.3 * 100 is below 230 in floating point
    EXPECT_EQ(frames("0.99", 1), 1);
    EXPECT_EQ(frames("1.99", 1), 2);
    EXPECT_EQ(read("time,lamp,gain\n0,lamp,1\n").frame_count(25), 1);
    EXPECT_THROW(frames("2", 0), UsageError);
    EXPECT_THROW(frames("2", -1), UsageError);
    EXPECT_THROW(frames("2", std::nan("")), UsageError);
    EXPECT_THROW(frames("2000", 1000), UsageError);
}

TEST_F(AnimationTest, ErrorsOfHeaders) {
    expect_error("", {"path.csv:1:", "columns"});
    expect_error("time,lamp,x\n", {"path.csv:1:", "no key"});
    expect_error("time,x,y,z\n0,1,1,1\n", {"path.csv:1:", "time,lamp,x,y,z,gain", "eye_x"});
    expect_error("lamp,x\nlamp,1\n", {"path.csv:1: time:", "missing", "time,lamp"});
    expect_error("# lamps\ntime,lamp,colour\n0,lamp,1\n", {"path.csv:2: colour:", "unknown", "time,lamp,x"});
    expect_error("time,eye_x,eye_y\n0,1,1\n", {"path.csv:1: eye_z:", "missing"});
    expect_error(kCamera + ",roll\n0,1,1,1,1,1,1,1\n", {"path.csv:1: roll:", "unknown", "fov"});
}

TEST_F(AnimationTest, ErrorsOfKeys) {
    const std::string header = "time,lamp,x,y,z,gain\n";
    expect_error(header + "0,sun,,,,1\n", {"path.csv:2: lamp:", "'sun'", "lamp, other"});
    expect_error(header + "-1,lamp,,,,1\n", {"path.csv:2: time:", "allowed: 0 to"});
    expect_error(header + ",lamp,,,,1\n", {"path.csv:2: time:", "empty"});
    expect_error(header + "1,lamp,,,,1\n0.5,other,,,,1\n1,lamp,,,,2\n", {"path.csv:4: time:", "increase"});
    expect_error(header + "1,lamp,,,,-1\n", {"path.csv:2: gain:", "allowed: 0 to"});
    expect_error(header + "1,lamp,a,,,\n", {"path.csv:2: x:", "'a' is no number"});
    expect_error(header + "1,lamp,11,,40,\n", {"path.csv:2: x,z:", "outside its domain", "13.5,23.5,33.5"});
    expect_error(kCamera + "\n0,1,1,1,1,1,1\n0,2,1,1,1,1,1\n", {"path.csv:2: target_x:", "same point"});
    expect_error(kCamera + "\n1,1,1,2,1,1,1\n1,2,1,1,1,1,1\n", {"path.csv:3: time:", "increase"});
    expect_error(kCamera + "\n1,1,,2,1,1,1\n", {"path.csv:2: eye_y:", "empty"});
    expect_error(kCamera + ",fov\n1,1,1,2,1,1,1,0\n", {"path.csv:2: fov:", "0.1 to 179"});
}

TEST(FrameName, OneNumber) {
    EXPECT_EQ(frame_name("frame_%04d.png", 7), "frame_0007.png");
    EXPECT_EQ(frame_name("frame_%04d.png", 12345), "frame_12345.png");
    EXPECT_EQ(frame_name("100%/a/%d.exr", 7), "100%/a/7.exr");
    EXPECT_EQ(frame_name("%09d", 7), "000000007");
    EXPECT_EQ(frame_name("{}%03d{}.png", 7), "{}007{}.png");
    EXPECT_EQ(frame_record("a/frame_%04d.png"), "a/frame_%04d.png.record");
}

TEST(FrameName, AnythingElseIsRefused) {
    for (const char* pattern :
         {"frame.png", "%d_%d.png", "%s.png", "%4d.png", "%00d.png", "%010d.png", "%%d.png", "%d%.png", "%",
          "%0", "%04", "%n", "%-4d.png", "%d/frame.png", "%04x.png", ""})
        EXPECT_THROW(frame_name(pattern, 1), UsageError) << pattern;
    EXPECT_EQ(message_of<UsageError>([] { frame_name("a.png", 1); }),
              "'a.png' must hold one number as %d or %04d in its file's name, as in frame_%04d.png, and no "
              "other %");
    EXPECT_THROW(missing_frames("a.png", 1, "key"), UsageError);
}

class MissingFrames : public testing::Test {
  protected:
    TemporaryFolder folder_;
    std::filesystem::path pattern_ = folder_ / "f%02d.png";
    void render(int number) const {
        folder_.write(frame_name("f%02d.png", number).string(), "picture");
        record_frame(pattern_, number);
    }
    std::vector<int> missing(int count, const std::string& key, bool overwrite = false) const {
        return missing_frames(pattern_, count, key, overwrite);
    }
    using Numbers = std::vector<int>;
};

TEST_F(MissingFrames, GoesOnWhereItStopped) {
    EXPECT_EQ(missing(4, "key"), (Numbers{0, 1, 2, 3}));
    render(0), render(2);
    EXPECT_EQ(missing(4, "key"), (Numbers{1, 3}));
    EXPECT_EQ(missing(5, "key"), (Numbers{1, 3, 4}));
    render(1), render(3);
    EXPECT_EQ(missing(4, "key"), Numbers{});
    std::filesystem::remove(folder_ / "f02.png");
    EXPECT_EQ(missing(4, "key"), Numbers{2});
}

TEST_F(MissingFrames, FrameThatWasNotRecordedIsRenderedAgain) {
    missing(2, "key");
    folder_.write("f01.png", "half a picture");
    EXPECT_EQ(missing(2, "key"), (Numbers{0, 1}));
}

TEST_F(MissingFrames, OtherKeyIsRefused) {
    missing(2, "key");
    render(0);
    const std::string message = message_of<Error>([&] { missing(2, "other key"); });
    EXPECT_NE(message.find("f%02d.png.record"), std::string::npos) << message;
    EXPECT_NE(message.find("--overwrite"), std::string::npos) << message;
    EXPECT_EQ(missing(2, "key"), Numbers{1});  // nothing was touched
}

TEST_F(MissingFrames, OverwriteStartsAnew) {
    missing(3, "key");
    render(0), render(2);
    folder_.write("f01.png", "not ours");
    EXPECT_EQ(missing(2, "other key", true), (Numbers{0, 1}));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "f00.png"));
    EXPECT_FALSE(std::filesystem::exists(folder_ / "f02.png"));  // would end up in the new film
    EXPECT_TRUE(std::filesystem::exists(folder_ / "f01.png"));
    render(0);
    EXPECT_EQ(missing(2, "other key"), Numbers{1});
    EXPECT_EQ(missing(2, "other key", true), (Numbers{0, 1}));
}

TEST_F(MissingFrames, StrangersAreNotTouched) {
    folder_.write("f01.png", "holiday");
    const std::string message = message_of<Error>([&] { missing(2, "key"); });
    EXPECT_NE(message.find("f01.png: exists"), std::string::npos) << message;
    EXPECT_EQ(missing(2, "key", true), (Numbers{0, 1}));
    EXPECT_EQ(bytes_of(folder_ / "f01.png"), "holiday");
}

TEST_F(MissingFrames, TornAndStrangeRecords) {
    missing(20, "key");
    const std::string title = bytes_of(frame_record(pattern_));
    folder_.write("f01.png", "x"), folder_.write("f15.png", "x");
    folder_.write("f%02d.png.record", title + "done 1");  // cut off: it may have been 15
    EXPECT_EQ(missing(20, "key").size(), 20u);
    record_frame(pattern_, 5);
    EXPECT_EQ(missing(20, "key").size(), 20u);
    record_frame(pattern_, 15);
    EXPECT_EQ(missing(20, "key").size(), 19u);
    for (const char* strange : {"", "shopping list\n", "pim frames of 12"}) {
        folder_.write("f%02d.png.record", strange);
        const std::string message = message_of<Error>([&] { missing(20, "key", true); });
        EXPECT_NE(message.find("no record of frames"), std::string::npos) << message;
    }
}

}  // namespace
}  // namespace pim
