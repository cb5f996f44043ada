// SPDX-License-Identifier: GPL-3.0-or-later
// The fit's least squares on NIST's certified regressions, as they are stated: raw powers, no scaling.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bake/least_squares.h"
#include "stability_table.h"

namespace pim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

Extended number(const json& text) { return std::strtold(text.get<std::string>().c_str(), nullptr); }

ExtendedVector numbers(const json& texts) {
    ExtendedVector v(Index(texts.size()));
    for (std::size_t i = 0; i < texts.size(); ++i) v(Index(i)) = number(texts[i]);
    return v;
}

struct Regression {
    ExtendedMatrix design;
    ExtendedVector y, certified;
};

Regression read(const std::string& name) {
    std::ifstream file(PIM_TEST_DATA "/nist.json");
    const json set = json::parse(file).at(name);
    Regression r{{}, numbers(set.at("y")), numbers(set.at("coefficients"))};
    r.design.resize(r.y.size(), r.certified.size());
    for (Index i = 0; i < r.y.size(); ++i) {
        const json& x = set.at("x")[std::size_t(i)];
        Extended power = 1;
        for (Index j = 0; j < r.certified.size(); ++j) {
            if (set.at("model") == "variables") {
                r.design(i, j) = j == 0 ? 1 : number(x[std::size_t(j - 1)]);
            } else if (set.at("model") == "powers") {
                r.design(i, j) = power;
                power *= number(x);
            } else {
                r.design(i, j) = number(x);
            }
        }
    }
    return r;
}

// Digits of the worst coefficient; NIST certifies 15.
double digits(const ExtendedVector& found, const ExtendedVector& certified) {
    double worst = 15;
    for (Index i = 0; i < found.size(); ++i) {
        const double error = double(std::abs(found(i) - certified(i)) / std::abs(certified(i)));
        if (!std::isfinite(error)) return 0;
        if (error > 0) worst = std::min(worst, -std::log10(error));
    }
    return std::max(0.0, worst);
}

class Nist : public testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(Nist, DigitsOfTheWorstCoefficient) {
    const auto& [name, mark] = GetParam();
    const Regression r = read(name);
    std::vector<int> order(std::size_t(r.design.cols()));
    std::iota(order.begin(), order.end(), 0);
    const LeastSquares ls = factorise(r.design, order, 0);
    ASSERT_EQ(ls.rank(), int(r.design.cols()));
    const double own = digits(ls.solution(r.y), r.certified);
    EXPECT_GE(own, mark);

    const MatrixXd a = r.design.cast<double>();
    const VectorXd y = r.y.cast<double>();
    const auto plain = [&](const VectorXd& x) { return digits(x.cast<Extended>(), r.certified); };
    const double qr = plain(a.householderQr().solve(y)),
                 svd = plain(a.jacobiSvd(Eigen::ComputeThinU | Eigen::ComputeThinV).solve(y)),
                 normal = plain((a.transpose() * a).ldlt().solve(a.transpose() * y));
    EXPECT_GE(own, std::max({qr, svd, normal}) - 0.5);
    add_to_table("nist", {name, fmt::format("{:.2g}", ls.condition_number), fmt::format("{:.1f}", own),
                          fmt::format("{:g}", mark), fmt::format("{:.1f}", qr), fmt::format("{:.1f}", svd),
                          fmt::format("{:.1f}", normal)});
}

INSTANTIATE_TEST_SUITE_P(Certified, Nist,
                         testing::Values(std::pair{"Filip", 9.0}, std::pair{"Longley", 11.0},
                                         std::pair{"Wampler1", 11.0}, std::pair{"Wampler2", 11.0},
                                         std::pair{"Wampler3", 11.0}, std::pair{"Wampler4", 8.0},
                                         std::pair{"Wampler5", 8.0}, std::pair{"Norris", 12.0},
                                         std::pair{"NoInt1", 12.0}, std::pair{"NoInt2", 12.0},
                                         std::pair{"Pontius", 12.0}),
                         [](const auto& test) { return std::string(test.param.first); });

}  // namespace
}  // namespace pim
