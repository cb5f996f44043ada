// SPDX-License-Identifier: GPL-3.0-or-later
#include "viewer/files/probe.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/core/error.h"
#include "temporary_folder.h"
#include "test_scenes.h"
#include "viewer/files/csv.h"

namespace pim {
namespace {

using Values = std::vector<std::string>;

std::string csv_error(const std::string& text) {
    return message_of<Error>([&] { parse_csv(text, "t.csv"); });
}

TEST(Csv, RowsAndLines) {
    const CsvTable table = parse_csv("# made by hand\n\na,b,c\n1,2,3\n\n  # more\n4,,6\n", "t.csv");
    EXPECT_EQ(table.header.line, 3);
    EXPECT_EQ(table.header.values, (Values{"a", "b", "c"}));
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_EQ(table.rows[0].line, 4);
    EXPECT_EQ(table.rows[1].line, 7);
    EXPECT_EQ(table.rows[1].values, (Values{"4", "", "6"}));
    EXPECT_TRUE(table.has("c"));
    EXPECT_FALSE(table.has("d"));
}

TEST(Csv, AsSpreadsheetsWriteIt) {
    const CsvTable table = parse_csv(
        "\xEF\xBB\xBF\"a\", b ,c\r\n\"x, y\",\"say \"\"hi\"\"\",\"\"\r\n \" p \" ,\tq\t,r", "t.csv");
    EXPECT_EQ(table.header.values, (Values{"a", "b", "c"}));
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_EQ(table.rows[0].values, (Values{"x, y", "say \"hi\"", ""}));
    EXPECT_EQ(table.rows[1].values, (Values{" p ", "q", "r"}));
}

TEST(Csv, ErrorsOfShape) {
    EXPECT_EQ(csv_error(""), "t.csv:1: is empty; the first line must name the columns");
    EXPECT_EQ(csv_error("# nothing\n"), "t.csv:1: is empty; the first line must name the columns");
    EXPECT_EQ(csv_error("a,b\n1,2\n1\n"), "t.csv:3: has 1 values; the header names 2 columns: a,b");
    EXPECT_EQ(csv_error("a,b\n1,2,3\n"), "t.csv:2: has 3 values; the header names 2 columns: a,b");
    EXPECT_EQ(csv_error("a,\n1,2\n"), "t.csv:1: a column has no name");
    EXPECT_EQ(csv_error("a,b,a\n"), "t.csv:1: two columns are named a");
    EXPECT_EQ(csv_error("a\n\"1\n2\"\n"), "t.csv:2: a quote is left open; a value must end on its own line");
    EXPECT_EQ(csv_error("a\n\"1\"2\n"), "t.csv:2: a comma must follow the quote that closes a value");
}

TEST(Csv, NumbersAreStrict) {
    const auto number = [](const std::string& text) {
        const CsvTable table = parse_csv("a,b\n0," + text + "\n", "t.csv");
        return csv_number(table, table.rows[0], "b", {-10, 1000});
    };
    EXPECT_EQ(number("1.5"), 1.5);
    EXPECT_EQ(number("-2e-3"), -0.002);
    EXPECT_EQ(number("\"7\""), 7);
    for (const char* text : {"1.5m", "0x10", "1,5", "inf", "nan", "1e999", "+1", "one", "1 2", "--1"})
        EXPECT_NE(message_of<Error>([&] {
                      number(fmt::format("\"{}\"", text));
                  }).find(fmt::format("t.csv:2: b: '{}' is no number", text)),
                  std::string::npos)
            << text;
    EXPECT_EQ(message_of<Error>([&] { number(""); }), "t.csv:2: b: is empty; it must be a number");
    EXPECT_EQ(message_of<Error>([&] { number("1001"); }),
              "t.csv:2: b: 1001 is out of range; allowed: -10 to 1000");
    const CsvTable table = parse_csv("a,b\n0,\n", "t.csv");
    EXPECT_FALSE(csv_optional_number(table, table.rows[0], "b"));
    EXPECT_FALSE(csv_optional_number(table, table.rows[0], "absent"));
}

class Probe : public testing::Test {
  protected:
    Probe() : scene_(room(Rgb(0.5f), Vec3(4))) { scene_.geometry.origin = {10.1, 20, 30}; }
    std::vector<ProbePoint> read(const std::string& text) const {
        return read_probe(folder_.write("p.csv", text), scene_);
    }
    std::string error(const std::string& text) const {
        const std::string message = message_of<Error>([&] { read(text); });
        return message.substr(std::min(message.size(), folder_.path().string().size() + 1));
    }
    const std::string kHeader = "x,y,z,nx,ny,nz\n";
    Scene scene_;
    TemporaryFolder folder_;
};

TEST_F(Probe, PointsAreLocalAndNormalsUnit) {
    const auto points = read("# desk\n" + kHeader + "11.1,20,31,0,2,0\n12.1,21,30.5,3,0,-4\n");
    ASSERT_EQ(points.size(), 2u);
    EXPECT_EQ(points[0].world, Vec3d(11.1, 20, 31));
    EXPECT_EQ(points[0].position, Vec3(1, 0, 1));
    EXPECT_EQ(points[0].normal, Vec3(0, 1, 0));
    EXPECT_EQ(points[1].normal, Vec3(0.6f, 0, -0.8f));
}

TEST_F(Probe, Errors) {
    EXPECT_EQ(error("x,y,z\n1,2,3\n"), "p.csv:1: nx: the column is missing; needed: x,y,z,nx,ny,nz");
    EXPECT_EQ(error(kHeader), "p.csv:1: no point follows the header");
    EXPECT_EQ(error(kHeader + "1,2,3,0,1,0\n1,2,3,,,\n"), "p.csv:3: nx: is empty; it must be a number");
    EXPECT_EQ(error(kHeader + "1,2,3,0,0,0\n"), "p.csv:2: nx: the normal nx,ny,nz must not be 0,0,0");
    EXPECT_EQ(error(kHeader + "1,2,here,0,1,0\n"), "p.csv:2: z: 'here' is no number");
    EXPECT_EQ(error("x,y,z,nx,ny,nz,u\n1,2,3,0,1,0,0\n"),
              "p.csv:1: u: is unknown; allowed columns: x,y,z,nx,ny,nz");
}

TEST_F(Probe, TextHoldsPointsAndMeterReadings) {
    const auto points = read(kHeader + "11.1,20,31,0,2,0\n-0.3,1e-9,30.5,0,0,-1\n");
    const std::string text = probe_text(points, {Rgb(1), Rgb(0, 2, 0)});
    const CsvTable table = parse_csv(text, "out.csv");
    EXPECT_EQ(fmt::format("{}", fmt::join(table.header.values, ",")),
              "x,y,z,nx,ny,nz,red,green,blue,irradiance,lux");
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_TRUE(text.find("\n11.1,20,31,0,1,0,1,1,1,") != std::string::npos) << text;
    EXPECT_TRUE(text.find("\n-0.3,1e-09,30.5,0,0,-1,0,2,0,1.4304,") != std::string::npos) << text;
    EXPECT_NEAR(csv_number(table, table.rows[0], "irradiance"), 1, 1e-6);
    EXPECT_NEAR(csv_number(table, table.rows[0], "lux"), 683, 1e-3);
    EXPECT_NEAR(csv_number(table, table.rows[1], "lux"), 683 * 2 * 0.7152, 1e-3);
}

}  // namespace
}  // namespace pim
