// SPDX-License-Identifier: GPL-3.0-or-later
#include "bake/least_squares.h"

namespace pim {
namespace {

// Of A = Q R with the columns of A scaled to length 1.
double condition_of(ExtendedMatrix r) {
    if (r.size() == 0) return 1;
    for (Eigen::Index i = 0; i < r.cols(); ++i) r.col(i).normalize();
    const ExtendedVector singular = Eigen::JacobiSVD<ExtendedMatrix>(r).singularValues();
    return double(singular(0) / singular(singular.size() - 1));
}

}  // namespace

LeastSquares factorise(const ExtendedMatrix& design, const std::vector<int>& order, double independence) {
    const Eigen::Index rows = design.rows(), most = std::min<Eigen::Index>(rows, Eigen::Index(order.size()));
    ExtendedMatrix q(rows, most), r = ExtendedMatrix::Zero(most, most);
    LeastSquares result;
    for (const int column : order) {
        const auto rank = Eigen::Index(result.kept.size());
        ExtendedVector v = design.col(column);
        const Extended length = v.norm();
        ExtendedVector along = ExtendedVector::Zero(most);
        for (int pass = 0; pass < 2 && rank < most; ++pass)
            for (Eigen::Index i = 0; i < rank; ++i) {
                const Extended share = q.col(i).dot(v);
                along(i) += share;
                v -= share * q.col(i);
            }
        const Extended rest = v.norm();
        if (rank == most || !(rest > Extended(independence) * length)) {
            result.dropped.push_back(column);
            continue;
        }
        q.col(rank) = v / rest;
        r.col(rank) = along;
        r(rank, rank) = rest;
        result.kept.push_back(column);
    }
    const auto rank = Eigen::Index(result.kept.size());
    const ExtendedMatrix triangle = r.topLeftCorner(rank, rank);
    const ExtendedMatrix inverse =
        triangle.triangularView<Eigen::Upper>().solve(ExtendedMatrix::Identity(rank, rank));
    result.q = q.leftCols(rank);
    result.solve = ExtendedMatrix::Zero(design.cols(), rank);
    for (Eigen::Index i = 0; i < rank; ++i) result.solve.row(result.kept[std::size_t(i)]) = inverse.row(i);
    result.condition_number = condition_of(triangle);
    return result;
}

}  // namespace pim
