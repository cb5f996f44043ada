// SPDX-License-Identifier: GPL-3.0-or-later
// Polynomial texture maps: the file, the fit, and what the program says of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "common/core/error.h"
#include "small_maps.h"
#include "temporary_folder.h"
#include "viewer/ptm_export.h"

namespace pim {
namespace {

using nlohmann::json;

// The file by its description alone: values 0..255 of a display.
struct FileReader {
    std::string bytes;
    int width = 0, height = 0;
    double scale[6] = {};
    int bias[6] = {};
    std::size_t pixels = 0;  // where they begin

    explicit FileReader(const std::filesystem::path& file) : bytes(bytes_of(file)) {
        int used = 0;
        const int fields = std::sscanf(
            bytes.c_str(), "PTM_1.2\nPTM_FORMAT_LRGB\n%d\n%d\n%lf %lf %lf %lf %lf %lf\n%d %d %d %d %d %d%n",
            &width, &height, scale, scale + 1, scale + 2, scale + 3, scale + 4, scale + 5, bias, bias + 1,
            bias + 2, bias + 3, bias + 4, bias + 5, &used);
        EXPECT_EQ(fields, 14);
        EXPECT_EQ(bytes.at(std::size_t(used)), '\n');
        pixels = std::size_t(used) + 1;
        EXPECT_EQ(bytes.size(), pixels + 9 * std::size_t(width) * std::size_t(height));
    }
    int byte(std::size_t i) const { return uint8_t(bytes.at(pixels + i)); }
    // Column x, row y from the bottom.
    double shown(int x, int y, int channel, double u, double v) const {
        const auto p = std::size_t(y * width + x), count = std::size_t(width * height);
        const double terms[6] = {u * u, v * v, u * v, u, v, 1};
        double luminance = 0;
        for (std::size_t i = 0; i < 6; ++i) luminance += (byte(6 * p + i) - bias[i]) * scale[i] * terms[i];
        return std::clamp(byte(6 * count + 3 * p + std::size_t(channel)) * luminance / 255, 0.0, 255.0);
    }
};

// Of 3 x 2 pixels, each another biquadratic and colour.
Ptm small_ptm() {
    Ptm ptm{3, 2, {}, {}};
    for (int p = 0; p < 6; ++p) {
        const float s = float(p) / 5;
        ptm.luminance.push_back({0.3f * s, -0.2f * s, 0.1f - 0.3f * s, 0.2f, -0.1f * s, 0.5f + 0.1f * s});
        ptm.colours.push_back(Rgb(float(40 * p), 255, float(255 - 40 * p)) / 255.0f);
    }
    return ptm;
}

float half_sum(const std::array<float, kPtmTerms>& steps) {
    return std::accumulate(steps.begin(), steps.end(), 0.0f) / 2;
}

float largest_difference(const Image& a, const Image& b) {
    float largest = 0;
    for (std::size_t p = 0; p < a.pixels.size(); ++p)
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(a.pixels[p][c] - b.pixels[p][c]));
    return largest;
}

// ---- the file

TEST(PtmFile, IsWhatItsDescriptionSays) {
    const TemporaryFolder folder;
    const Ptm ptm = small_ptm();
    write_ptm(folder / "a.ptm", ptm);
    const FileReader file(folder / "a.ptm");
    ASSERT_EQ(file.width, 3);
    ASSERT_EQ(file.height, 2);
    const double allowed = 255 * double(half_sum(ptm_steps(ptm))) + 1e-3;
    for (const Vec2& uv : {Vec2(0, 0), Vec2(1, -1), Vec2(-0.3f, 0.8f)}) {
        const Image expected = relit(ptm, uv.x, uv.y);
        for (int y = 0; y < 2; ++y)
            for (int x = 0; x < 3; ++x)
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(file.shown(x, 1 - y, c, double(uv.x), double(uv.y)),
                                255 * expected.at(x, y)[c], allowed)
                        << x << " " << y;
    }
}

TEST(PtmFile, TheTopRowIsTheLastInTheFile) {
    const TemporaryFolder folder;
    Ptm ptm{1, 2, {{}, {}}, {Rgb(1, 0, 0), Rgb(0, 0, 1)}};  // red above blue
    ptm.luminance[0][5] = 1;
    write_ptm(folder / "a.ptm", ptm);
    const std::string bytes = bytes_of(folder / "a.ptm");
    const std::string pixels = bytes.substr(bytes.size() - 18);
    EXPECT_EQ(pixels.substr(5, 1), std::string(1, '\0'));
    EXPECT_EQ(pixels.substr(11, 1), "\xfe");  // 254 steps are full
    EXPECT_EQ(pixels.substr(12), std::string("\0\0\xff\xff\0\0", 6));
}

TEST(PtmFile, ReadsBackWithinHalfAStep) {
    const TemporaryFolder folder;
    const Ptm ptm = small_ptm();
    write_ptm(folder / "a.ptm", ptm);
    const Ptm read = read_ptm(folder / "a.ptm");
    ASSERT_EQ(read.width, 3);
    ASSERT_EQ(read.height, 2);
    const auto steps = ptm_steps(ptm);
    for (std::size_t p = 0; p < 6; ++p) {
        for (std::size_t i = 0; i < kPtmTerms; ++i)
            EXPECT_NEAR(read.luminance[p][i], ptm.luminance[p][i], 0.5f * steps[i] + 1e-6f) << i;
        for (int c = 0; c < 3; ++c) EXPECT_FLOAT_EQ(read.colours[p][c], ptm.colours[p][c]);
    }
    write_ptm(folder / "b.ptm", read);
    const Ptm again = read_ptm(folder / "b.ptm");
    EXPECT_EQ(again.colours, read.colours);
}

// A range far from 0, as a light that is always on has, and one of a single value.
TEST(PtmFile, ZeroIsExact) {
    const TemporaryFolder folder;
    Ptm ptm{2, 1, {{}, {}}, {Rgb(1), Rgb(1)}};
    ptm.luminance[0] = {0, -0.37f, 0.37f, 0, 0, 0.9f};
    ptm.luminance[1] = {0, 0, 0, 0, 0, 0.8f};
    write_ptm(folder / "a.ptm", ptm);
    const Ptm read = read_ptm(folder / "a.ptm");
    EXPECT_NEAR(read.luminance[0][1], -0.37f, 1e-6f);
    EXPECT_NEAR(read.luminance[0][2], 0.37f, 1e-6f);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(read.luminance[1][i], 0) << i;
    EXPECT_NEAR(read.luminance[1][5], 0.8f, 0.9f / 254 / 2);
    EXPECT_EQ(ptm_steps(ptm)[0], 0);
    EXPECT_FLOAT_EQ(ptm_steps(ptm)[5], 0.9f / 254);
}

TEST(PtmFile, OthersBreakTheirLinesElsewhere) {
    const TemporaryFolder folder;
    const std::string pixels("\1\2\3\4\5\n\xff\x80\0", 9);  // a newline among them
    const Ptm ptm = read_ptm(folder.write(
        "a.ptm", "PTM_1.2\r\nPTM_FORMAT_LRGB\r\n1 1\r\n2 2 2 2 2 25.5 1 1 1 1 1 0 \r\n" + pixels));
    EXPECT_FLOAT_EQ(ptm.luminance[0][2], 4.0f / 255);
    EXPECT_FLOAT_EQ(ptm.luminance[0][5], 1);
    EXPECT_FLOAT_EQ(ptm.colours[0].y, 128 / 255.0f);
}

TEST(PtmFile, BrokenOnesAreNamed) {
    const TemporaryFolder folder;
    const std::string header = "PTM_1.2\nPTM_FORMAT_LRGB\n1\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
    const auto problem = [&](const std::string& content) {
        const auto file = folder.write("a.ptm", content);
        const std::string message = message_of<Error>([&] { read_ptm(file); });
        EXPECT_EQ(message.find(file.string() + ": "), 0u) << message;
        return message.substr(std::min(message.size(), file.string().size() + 2));
    };
    EXPECT_EQ(problem(""), "is no polynomial texture map of version 1.2");
    EXPECT_EQ(problem("\x89PNG"), "is no polynomial texture map of version 1.2");
    EXPECT_EQ(problem("PTM_1.2\nPTM_FORMAT_RGB\n"),
              "its pixels are PTM_FORMAT_RGB; only PTM_FORMAT_LRGB can be read");
    for (const char* numbers :
         {"", "1\n", "1\n2\n1 1 1", "one\n2\n1 1 1 1 1 1\n0 0 0 0 0 0\n", "1\n2\n1 1 1 1 1 1\n0 0 0 0 0\n"})
        EXPECT_EQ(problem(std::string("PTM_1.2\nPTM_FORMAT_LRGB\n") + numbers),
                  "the header is damaged: it must give width, height, six scales, six biases");
    EXPECT_EQ(problem("PTM_1.2\nPTM_FORMAT_LRGB\n0\n-2\n1 1 1 1 1 1\n0 0 0 0 0 0\n"),
              "0 x -2 pixels; allowed: 1 to 32768 on each side");
    EXPECT_EQ(problem(header), "holds 0 bytes of pixels; 1 x 2 of them take 18");
    EXPECT_EQ(problem(header.substr(0, header.size() - 1)), "holds 0 bytes of pixels; 1 x 2 of them take 18");
    EXPECT_EQ(problem(header + std::string(17, 'x')), "holds 17 bytes of pixels; 1 x 2 of them take 18");
    EXPECT_EQ(problem(header + std::string(19, 'x')), "holds 19 bytes of pixels; 1 x 2 of them take 18");
    EXPECT_NE(message_of<Error>([&] { read_ptm(folder / "none.ptm"); }), "");
}

// ---- the fit

TEST(PtmFit, TheLampMovesAlongTheTwoLongerAxes) {
    const Vec3 at(1.5f, 4, 7);
    const auto axes = [&](const Vec3& size) {
        const auto plane = lamp_plane({Vec3(1, 2, 3), Vec3(1, 2, 3) + size}, at);
        return plane ? plane->axes : std::array<int, 2>{-1, -1};
    };
    EXPECT_EQ(axes({3, 2, 1}), (std::array{0, 1}));
    EXPECT_EQ(axes({1, 2, 3}), (std::array{1, 2}));
    EXPECT_EQ(axes({5, 2.5f, 5}), (std::array{0, 2}));
    EXPECT_EQ(axes({0, 1, 1}), (std::array{1, 2}));
    EXPECT_EQ(axes({4, 4, 4}), (std::array{0, 1}));
    for (const Vec3& flat : {Vec3(0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
        EXPECT_EQ(axes(flat)[0], -1);
    const LampPlane plane = *lamp_plane({Vec3(1, 2, 3), Vec3(5, 2.5f, 11)}, at);
    EXPECT_EQ(plane.at({-1, -1}), Vec3(1, 4, 3));
    EXPECT_EQ(plane.at({1, -1}), Vec3(5, 4, 3));
    EXPECT_EQ(plane.at({0, 0.5f}), Vec3(3, 4, 9));
}

// On n × n Chebyshev nodes, n > 4, the means of u², u⁴, u²v² are 1/2, 3/8, 1/4 and the odd ones 0: AᵀA / n²
// has the eigenvalues 1/4 (uv), 1/2 (u, v), 1/8 (u² − v²) and those of [[5/8, 1/√2], [1/√2, 1]] (u² + v², 1).
TEST(PtmFit, SingularValuesOfChebyshevNodes) {
    const PtmDesign design(chebyshev_grid(8));
    const double root = std::sqrt(169.0 / 64 - 0.5);
    const double squares[] = {(1.625 + root) / 2, 0.5, 0.5, 0.25, 0.125, (1.625 - root) / 2};
    for (std::size_t i = 0; i < kPtmTerms; ++i)
        EXPECT_NEAR(design.singular_values[i], 8 * std::sqrt(squares[i]), 1e-5) << i;
    EXPECT_NEAR(design.condition_number(), std::sqrt(squares[0] / squares[5]), 1e-6);
}

// Encoded values of a pixel under a lamp: one colour, its brightness a biquadratic with values in 0..1.
Rgb biquadratic_pixel(int p, const Vec2& uv) {
    const float s = float(p) / 12, u = uv.x, v = uv.y;
    const float y = 0.4f + 0.1f * u * u - 0.15f * s * v * v + 0.1f * u * v - 0.2f * s * u + 0.1f * v;
    return Rgb(1 - 0.6f * s, 0.8f, 0.3f + 0.5f * s) * y;
}

Image biquadratic_picture(const Vec2& uv) {
    Image image(4, 3);
    for (int p = 0; p < 12; ++p) image.pixels[std::size_t(p)] = biquadratic_pixel(p, uv);
    return image;
}

Ptm fitted(const std::vector<Vec2>& lamps, const std::function<Image(const Vec2&)>& picture) {
    const PtmDesign design(lamps);
    const Image first = picture(lamps[0]);
    PtmFit fit({first.width, first.height}, design);
    for (std::size_t k = 0; k < lamps.size(); ++k) fit.add(k, picture(lamps[k]));
    return fit.lrgb();
}

TEST(PtmFit, BiquadraticsOfOneColourComeBack) {
    const TemporaryFolder folder;
    const Ptm ptm = fitted(chebyshev_grid(8), biquadratic_picture);
    write_ptm(folder / "a.ptm", ptm);
    const Ptm written = read_ptm(folder / "a.ptm");
    // L is off by half the steps' sum, times a colour of 1 at most; a colour byte by half, times L.
    float most = 0;
    for (const Vec2& uv : {Vec2(-1, -1), Vec2(1, 1), Vec2(0.3f, -0.9f), Vec2(0, 0)}) {
        const Image expected = biquadratic_picture(uv);
        EXPECT_LT(largest_difference(relit(ptm, uv.x, uv.y), expected), 1e-5f);
        const float off = largest_difference(relit(written, uv.x, uv.y), expected);
        EXPECT_LT(off, half_sum(ptm_steps(ptm)) + 1.2f * 0.5f / 255);
        most = std::max(most, off);
    }
    EXPECT_GT(most, 0.1f / 255);  // it did go through bytes
}

TEST(PtmFit, AColourIsThatOfThePixelsBrightestMoment) {
    const Ptm ptm = fitted(chebyshev_grid(5), biquadratic_picture);
    for (std::size_t p = 0; p < 12; ++p) {
        Rgb brightest(0);
        for (const Vec2& uv : chebyshev_grid(5)) {
            const Rgb colour = biquadratic_pixel(int(p), uv);
            if (luminance(colour) > luminance(brightest)) brightest = colour;
        }
        EXPECT_LT((ptm.colours[p] - brightest).length(), 1e-5f);
    }
}

// Colours that change with the lamp: what is kept is the chromaticity c that minimises Σ |colour − Y c|².
TEST(PtmFit, ChromaticityIsLeastSquares) {
    const auto lamps = chebyshev_grid(4);
    const auto colour = [](const Vec2& uv) {
        return Rgb(0.5f + 0.4f * uv.x, 0.4f, 0.5f - 0.4f * uv.x) * (0.6f + 0.3f * uv.y);
    };
    const Ptm ptm = fitted(lamps, [&](const Vec2& uv) {
        Image image(1, 1);
        image.pixels[0] = colour(uv);
        return image;
    });
    const auto misfit = [&](const Rgb& c) {
        double sum = 0;
        for (const Vec2& uv : lamps) sum += (colour(uv) - c * luminance(colour(uv))).length2();
        return sum;
    };
    const Rgb c = ptm.colours[0] / luminance(ptm.colours[0]);
    for (int i = 0; i < 3; ++i)
        for (const float h : {-0.01f, 0.01f}) {
            Rgb other = c;
            other[i] += h;
            EXPECT_GT(misfit(other), misfit(c));
        }
}

// No colour leaves 0..1, also where the brightest luminance belongs to another chromaticity; and pixels that
// are all but black bring no wild coefficients into the range of all.
TEST(PtmFit, ColoursFitIntoBytes) {
    const Ptm ptm = fitted(chebyshev_grid(4), [](const Vec2& uv) {
        Image image(2, 1);
        image.pixels = {uv.x > 0 ? Rgb(1, 1, 1) : Rgb(0, 0, 1), Rgb(uv.x > 0 ? 1e-5f : 0, 1e-6f, 0)};
        return image;
    });
    EXPECT_LE(max_channel(ptm.colours[0]), 1.00001f);
    EXPECT_EQ(ptm.colours[1], Rgb(0));
    for (const float a : ptm.luminance[1]) EXPECT_EQ(a, 0);
}

// ---- the program

Outcome view(const std::string& options, const Baked& baked = small_map(SmallMap::by_facing)) {
    return run_project("viewer " + baked.map_file.string() + " " + options + " --quiet");
}

json report(const std::string& options) {
    const Outcome outcome = view(options);
    EXPECT_EQ(outcome.code, 0) << options << "\n" << outcome.errors;
    return json::parse(outcome.text);
}

std::string in_folder(const std::string& name) { return (test_folder() / name).string(); }

// The file shows what the viewer shows, as far as its error goes; and the report's error is the file's.
TEST(PtmExport, ShowsTheScene) {
    const std::string file = in_folder("room.ptm"),
                      options = "--size 40x40 --exposure=-1 --camera near --gain lamp=0.5 ";
    const json j = report(options + "--export-ptm " + file);
    EXPECT_EQ(j["lamp"], "lamp");
    EXPECT_EQ(j["u"]["axis"], "x");
    EXPECT_EQ(j["v"]["axis"], "z");
    EXPECT_NEAR(j["v"]["from"].get<double>(), 1, 1e-5);
    EXPECT_NEAR(j["v"]["to"].get<double>(), 4, 1e-5);
    EXPECT_EQ(j["bytes"], fs::file_size(file));
    EXPECT_EQ(j["exposure"], -1);
    EXPECT_EQ(j["lamp_positions"], 64);
    EXPECT_EQ(j["relrmse_per_position"].size(), 16u);
    EXPECT_FALSE(j.contains("relrmse_map"));
    const Ptm ptm = read_ptm(file);
    EXPECT_EQ(ptm.width, 40);
    const auto error = [&](const char* light, float u, float v) {
        EXPECT_EQ(view(options + "--output " + in_folder("still.exr") + " --light lamp=" + light).code, 0);
        const Image seen = read_image(in_folder("still.exr")), shown = relit(ptm, u, v);
        double difference = 0, norm = 0;
        for (std::size_t p = 0; p < seen.pixels.size(); ++p)
            for (int c = 0; c < 3; ++c) {
                const double linear = 2 * srgb_decode(shown.pixels[p][c]), r = seen.pixels[p][c];
                difference += (linear - r) * (linear - r), norm += r * r;
            }
        return std::sqrt(difference / norm);
    };
    // The domain is 1..4 in x and z; y stays at its middle. Where (u, v) is taken for another place, it is
    // seen.
    const double right = error("3.1,4.25,1.6", 0.4f, -0.6f);
    EXPECT_LT(right, 2 * j["relrmse"].get<double>());
    EXPECT_GT(error("3.1,4.25,1.6", 0.4f, 0.6f), 1.5 * right);
    EXPECT_GT(error("3.1,4.25,1.6", -0.4f, -0.6f), 1.5 * right);
    EXPECT_GT(error("3.1,4.25,1.6", -0.6f, 0.4f), 1.5 * right);
}

TEST(PtmExport, PartsExplainTheError) {
    const json j = report("--size 32x32 --export-ptm " + in_folder("parts.ptm"));
    const double all = j["relrmse"];
    double sum = 0, squares = 0;
    for (const auto& [name, part] : j["parts"].items()) {
        EXPECT_GT(part.get<double>(), 0) << name;
        sum += part.get<double>(), squares += part.get<double>() * part.get<double>();
    }
    EXPECT_LT(all, sum);
    EXPECT_GT(all, 0.5 * std::sqrt(squares));
    EXPECT_LT(j["parts"]["quantisation"], 0.03);
    EXPECT_LT(j["parts"]["clipping"], 0.2);  // automatic exposure
}

// The map follows paths better than six numbers a pixel do, and the noise of the pictures counts for neither.
TEST(PtmExport, PathTracedOnesAreComparedWithTheMap) {
    const std::string options =
        "--size 24x24 --direct traced --integrator path --export-ptm " + in_folder("paths.ptm");
    const json rough = report(options + " --spp 64"), fine = report(options + " --spp 192 --seed 5");
    EXPECT_LT(fine["relrmse_map"], fine["relrmse"]);
    EXPECT_GT(fine["relrmse"], 0.03);
    EXPECT_LT(fine["relrmse"], 0.5);
    for (const char* key : {"relrmse", "relrmse_map"})
        EXPECT_NEAR(rough[key], fine[key].get<double>(), 0.2 * fine[key].get<double>()) << key;
}

TEST(PtmExport, TheReportGoesToAFileOnRequest) {
    const Outcome outcome =
        view("--size 8x8 --export-ptm " + in_folder("a.ptm") + " --stats " + in_folder("a.json"));
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_EQ(outcome.text, "");
    EXPECT_EQ(json::parse(read_text(in_folder("a.json")))["width"], 8);
}

TEST(PtmExport, SameBytesAgain) {
    for (const char* name : {"one.ptm", "two.ptm"}) report("--size 16x16 --export-ptm " + in_folder(name));
    EXPECT_EQ(read_text(in_folder("one.ptm")), read_text(in_folder("two.ptm")));
}

TEST(PtmExport, Refusals) {
    const std::string file = " --export-ptm " + in_folder("no.ptm");
    const auto refused = [](const std::string& options, const std::string& words, int code = 2) {
        const Outcome outcome = view(options);
        EXPECT_EQ(outcome.code, code) << options;
        EXPECT_NE(outcome.errors.find(words), std::string::npos) << options << "\n" << outcome.errors;
        EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << outcome.errors;
    };
    for (const char* other : {" --output x.png", " --ui --output x.png", " --path x.csv", " --probe x.csv",
                              " --benchmark", " --export-scene x"})
        refused(file + other, "--export-ptm");
    refused("--ptm-lamp lamp --output x.png", "--ptm-lamp: of --export-ptm only");
    refused("--export-ptm x.png", "name the file so");
    refused("--export-ptm /nowhere/x.ptm", "/nowhere", 1);
    refused(file + " --ptm-lamp sun", "sun");
    refused(file + " --gain lamp=0", "no lamp shines");
    refused(file + " --gain lamp=0 --ptm-lamp lamp", "lamp does not shine");
    refused(file + " --view irradiance", "--view");
    refused(file + " --tone-curve aces", "--tone-curve");
    refused(file + " --integrator whitted", "--integrator");
    refused(file + " --integrator photon_map", "--integrator");
    refused(file + " --volume x.vdb", "--volume");
    refused(file + " --fps 3 --overwrite", "--overwrite");
    EXPECT_FALSE(fs::exists(in_folder("no.ptm")));
}

TEST(PtmExport, ALampOnALineIsRefused) {
    const fs::path description = test_folder() / "line.toml";
    std::string text = small_description(SmallMap::of_thesis);
    text.replace(text.find("max = [4, 4.9, 4]"), 17, "max = [4, 3.6, 1]");
    std::ofstream(description) << text;
    const Baked baked(description, test_folder() / "line.vdb");
    const Outcome outcome = view("--export-ptm " + in_folder("line.ptm"), baked);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.errors.find("the domain of lamp extends on fewer than two axes"), std::string::npos)
        << outcome.errors;
}

}  // namespace
}  // namespace pim
