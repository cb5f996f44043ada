// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/least_squares.h"

namespace pim {
namespace {

using Extended = long double;
using ExtendedMatrix = Eigen::Matrix<Extended, Eigen::Dynamic, Eigen::Dynamic>;
using ExtendedVector = Eigen::Matrix<Extended, Eigen::Dynamic, 1>;

double condition_of(const Eigen::MatrixXd& design, const std::vector<int>& columns) {
    Eigen::MatrixXd scaled(design.rows(), Eigen::Index(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i)
        scaled.col(Eigen::Index(i)) = design.col(columns[i]).normalized();
    const Eigen::VectorXd singular = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
    return singular.size() ? singular(0) / singular(singular.size() - 1) : 1;
}

}  // namespace

LeastSquares factorise(const Eigen::MatrixXd& design, const std::vector<int>& order) {
    const Eigen::Index rows = design.rows(), most = std::min<Eigen::Index>(rows, Eigen::Index(order.size()));
    ExtendedMatrix q(rows, most), r = ExtendedMatrix::Zero(most, most);
    LeastSquares result;
    for (const int column : order) {
        const auto rank = Eigen::Index(result.kept.size());
        if (rank == most) break;
        ExtendedVector v = design.col(column).cast<Extended>();
        const Extended length = v.norm();
        ExtendedVector along = ExtendedVector::Zero(most);
        for (int pass = 0; pass < 2; ++pass)
            for (Eigen::Index i = 0; i < rank; ++i) {
                const Extended share = q.col(i).dot(v);
                along(i) += share;
                v -= share * q.col(i);
            }
        const Extended rest = v.norm();
        if (!(rest > kIndependence * length)) continue;
        q.col(rank) = v / rest;
        r.col(rank) = along;
        r(rank, rank) = rest;
        result.kept.push_back(column);
    }
    const auto rank = Eigen::Index(result.kept.size());
    const ExtendedMatrix inverse = r.topLeftCorner(rank, rank)
                                       .triangularView<Eigen::Upper>()
                                       .solve(ExtendedMatrix::Identity(rank, rank));
    result.q = q.leftCols(rank).cast<double>();
    result.solve = Eigen::MatrixXd::Zero(design.cols(), rank);
    for (Eigen::Index i = 0; i < rank; ++i) result.solve.row(result.kept[i]) = inverse.row(i).cast<double>();
    result.condition_number = condition_of(design, result.kept);
    return result;
}

}  // namespace pim
