/* Minimum-norm rates by Eigen, with sizes known at compile time. */
#include "eigen.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

extern "C" void bench_eigen_llt(const double *jacobian, const double *twist, double *rates) {
  Eigen::Map<const Eigen::Matrix<double, 6, 7>> J(jacobian);
  Eigen::Map<const Eigen::Matrix<double, 6, 1>> xi(twist);
  Eigen::Map<Eigen::Matrix<double, 7, 1>> out(rates);
  Eigen::Matrix<double, 6, 6> square = J * J.transpose();
  Eigen::Matrix<double, 6, 1> y = square.llt().solve(xi);
  out.noalias() = J.transpose() * y;
}
