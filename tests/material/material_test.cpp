// SPDX-License-Identifier: MIT
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <jampack/element/definite.hpp>
#include <jampack/material/hencky.hpp>
#include <jampack/material/linear_elastic.hpp>
#include <jampack/material/neo_hookean.hpp>
#include <jampack/material/st_venant_kirchhoff.hpp>
#include <limits>

#include "../catch.hpp"

using namespace jampack;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using jampack_tests::contains;

namespace {

template <class M, int Dim>
Deformation<Dim> deformation(const Matrix<Dim>& gradient) {
  Deformation<Dim> at{gradient, Matrix<Dim>::Identity(), 1 + gradient.trace() - Dim};
  if constexpr (M::finite_strain) {
    at.inverse_transpose = gradient.inverse().transpose();
    at.dilatation = gradient.determinant();
  }
  return at;
}

/// Energy of the whole material at one point, the dilatation not averaged.
template <class M, int Dim>
double energy(const M& material, const Matrix<Dim>& gradient) {
  const auto at = deformation<M, Dim>(gradient);
  return material.distortional_energy(at) + material.volumetric(at.dilatation).energy;
}

template <int Dim>
Matrix<Dim> some_gradient() {
  Eigen::Matrix3d gradient;
  gradient << 1.2, 0.3, -0.1, -0.2, 0.8, 0.25, 0.15, -0.3, 0.9;
  return gradient.topLeftCorner<Dim, Dim>();
}

/// The distortional tangent as a matrix, by finite differences of the stress.
template <class M, int Dim>
MatrixTangent<Dim> differences(const M& material, const Matrix<Dim>& gradient) {
  MatrixTangent<Dim> tangent;
  const double h = 1e-6;
  for (int c = 0; c < Dim * Dim; ++c) {
    Matrix<Dim> step = Matrix<Dim>::Zero();
    step(c % Dim, c / Dim) = h;
    const Matrix<Dim> change = (material.distortional_stress(deformation<M, Dim>(gradient + step)) -
                                material.distortional_stress(deformation<M, Dim>(gradient - step))) /
                               (2 * h);
    tangent.col(c) = change.reshaped();
  }
  return tangent;
}

/// The tangent as a matrix; a closed form written out: isotropic I (x) I + exchange F^-T (x) F^-T with legs
/// crossed.
template <class M, int Dim>
MatrixTangent<Dim> written_out(const M& material, const Matrix<Dim>& gradient) {
  const auto at = deformation<M, Dim>(gradient);
  if constexpr (HasMatrixTangent<M, Dim>)
    return material.distortional_tangent(at);
  else {
    const GradientTangent closed = material.distortional_tangent(at);
    MatrixTangent<Dim> tangent;
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j)
        for (int k = 0; k < Dim; ++k)
          for (int l = 0; l < Dim; ++l)
            tangent(Dim * j + i, Dim * l + k) =
                closed.isotropic * (i == k) * (j == l) +
                closed.exchange * at.inverse_transpose(i, l) * at.inverse_transpose(k, j);
    return tangent;
  }
}

/// Archetypes: the least a material may be, and one function less.
struct NoVolume {
  double density = 1;
  static constexpr bool finite_strain = true;
  void validate() const {}
  double distortional_energy(const Deformation<3>&) const { return 0; }
  Matrix<3> distortional_stress(const Deformation<3>&) const { return Matrix<3>::Zero(); }
  MatrixTangent<3> distortional_tangent(const Deformation<3>&) const { return MatrixTangent<3>::Zero(); }
};

struct Minimal : NoVolume {
  VolumetricResponse volumetric(double) const { return {0, 0, 0}; }
};

}  // namespace

TEMPLATE_TEST_CASE("stress is the derivative of the energy, the tangent that of the stress", "", NeoHookean,
                   NeoHookeanQuadratic, LinearElastic, StVenantKirchhoff, Hencky) {
  const TestType material{2.5, 0.4, 1};
  const auto check = [&]<int Dim>(std::integral_constant<int, Dim>) {
    const Matrix<Dim> gradient = some_gradient<Dim>();
    const double h = 1e-6;
    const Matrix<Dim> stress = material.distortional_stress(deformation<TestType, Dim>(gradient));
    for (int c = 0; c < Dim * Dim; ++c) {
      Matrix<Dim> step = Matrix<Dim>::Zero();
      step(c % Dim, c / Dim) = h;
      const auto up = deformation<TestType, Dim>(gradient + step),
                 down = deformation<TestType, Dim>(gradient - step);
      CHECK_THAT((material.distortional_energy(up) - material.distortional_energy(down)) / (2 * h),
                 WithinAbs(stress(c % Dim, c / Dim), 1e-8));
    }
    CHECK_THAT((differences(material, gradient) - written_out(material, gradient)).norm(),
               WithinAbs(0, 1e-8));
    for (const double dilatation : {0.4, 0.9, 1.0, 1.3}) {
      const auto at = material.volumetric(dilatation), up = material.volumetric(dilatation + h),
                 down = material.volumetric(dilatation - h);
      CHECK_THAT((up.energy - down.energy) / (2 * h), WithinAbs(at.slope, 1e-7));
      CHECK_THAT((up.slope - down.slope) / (2 * h), WithinAbs(at.curvature, 1e-6));
    }
  };
  check(std::integral_constant<int, 2>{});
  check(std::integral_constant<int, 3>{});
}

TEMPLATE_TEST_CASE("at small strain every material is Hooke's law", "", NeoHookean, NeoHookeanQuadratic,
                   LinearElastic, StVenantKirchhoff, Hencky) {
  // Curvature of the energy in uniaxial strain is lambda + 2 mu, in simple shear mu; uniaxial stress gives E,
  // nu.
  const double young = 3, poisson = 0.35, h = 1e-4;
  const TestType material{young, poisson, 1};
  const auto curvature = [&](const Eigen::Matrix3d& direction) {
    const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
    return (energy<TestType, 3>(material, identity + h * direction) -
            2 * energy<TestType, 3>(material, identity) +
            energy<TestType, 3>(material, identity - h * direction)) /
           (h * h);
  };
  Eigen::Matrix3d uniaxial = Eigen::Matrix3d::Zero(), shear = Eigen::Matrix3d::Zero(),
                  bar = Eigen::Matrix3d::Zero();
  uniaxial(0, 0) = 1;
  shear(0, 1) = 1;
  bar.diagonal() << 1, -poisson, -poisson;
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
               mu = young / (2 * (1 + poisson));
  CHECK_THAT(curvature(uniaxial), WithinRel(lambda + 2 * mu, 1e-6));
  CHECK_THAT(curvature(shear), WithinRel(mu, 1e-6));
  CHECK_THAT(curvature(bar), WithinRel(young, 1e-6));
}

TEMPLATE_TEST_CASE_SIG("finite-strain energies are invariant under rotation, small-strain ones are not", "",
                       ((int Dim), Dim), 2, 3) {
  Matrix<Dim> rotation;
  if constexpr (Dim == 2)
    rotation = Eigen::Rotation2Dd(2.0).toRotationMatrix();
  else
    rotation = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Matrix<Dim> gradient = some_gradient<Dim>();
  const NeoHookean finite{1, 0.4, 1};
  const LinearElastic small{1, 0.4, 1};
  const Matrix<Dim> turned = rotation * gradient;
  CHECK_THAT((energy<StVenantKirchhoff, Dim>({1, 0.4, 1}, turned)),
             WithinRel(energy<StVenantKirchhoff, Dim>({1, 0.4, 1}, gradient), 1e-12));
  CHECK_THAT((energy<Hencky, Dim>({1, 0.4, 1}, turned)),
             WithinRel(energy<Hencky, Dim>({1, 0.4, 1}, gradient), 1e-12));
  CHECK_THAT((energy<NeoHookean, Dim>(finite, turned)),
             WithinRel(energy<NeoHookean, Dim>(finite, gradient), 1e-12));
  CHECK((energy<LinearElastic, Dim>(small, turned)) > 2 * energy<LinearElastic, Dim>(small, gradient));
}

TEST_CASE("neo-Hookean uniaxial stretch with free sides, closed form at nu = 0") {
  // lambda = 0: the sides stay as they are and P = mu (s - 1/s).
  const NeoHookean material{2, 0, 1};
  for (const double s : {0.5, 0.9, 1.5}) {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
    gradient(2, 2) = s;
    const Eigen::Matrix3d stress = material.distortional_stress(deformation<NeoHookean, 3>(gradient));
    CHECK_THAT(stress(2, 2), WithinRel(s - 1 / s, 1e-13));
    CHECK_THAT(stress(0, 0), WithinAbs(0, 1e-15));
  }
}

TEST_CASE("uniaxial stretch of the St Venant-Kirchhoff and the Hencky solid, closed forms") {
  // Distortional parts, mu = 1: P = s (s^2 - 1) and 2 ln s / s.
  const StVenantKirchhoff green{2, 0, 1};
  const Hencky logarithmic{2, 0, 1};
  for (const double s : {0.5, 0.9, 1.5}) {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
    gradient(1, 1) = s;
    const auto at = deformation<Hencky, 3>(gradient);
    const Eigen::Matrix3d first = green.distortional_stress(at), second = logarithmic.distortional_stress(at);
    CHECK_THAT(first(1, 1), WithinRel(s * (s * s - 1), 1e-13));
    CHECK_THAT(second(1, 1), WithinRel(2 * std::log(s) / s, 1e-13));
    CHECK_THAT(std::hypot(first(0, 0), second(2, 2)), WithinAbs(0, 1e-15));
  }
}

TEST_CASE("the Hencky solid has the same energy in F and its inverse") {
  const Hencky material{1, 0.4, 1};
  const Matrix<3> gradient = some_gradient<3>(), inverse = gradient.inverse();
  CHECK_THAT((energy<Hencky, 3>(material, inverse)), WithinRel(energy<Hencky, 3>(material, gradient), 1e-12));
}

TEMPLATE_TEST_CASE_SIG("the Hencky tangent where principal stretches coincide, or nearly do", "",
                       ((int Dim), Dim), 2, 3) {
  const Hencky material{2.5, 0.4, 1};
  for (const double apart : {0.0, 1e-9, 1e-7, 3e-6, 1e-4}) {
    Matrix<Dim> gradient = 0.8 * Matrix<Dim>::Identity();
    gradient(0, 0) += apart;
    INFO("apart by " << apart);
    CHECK_THAT((differences(material, gradient) - written_out(material, gradient)).norm(),
               WithinAbs(0, 1e-7));
  }
}

TEMPLATE_TEST_CASE_SIG("the definite tangent has no negative eigenvalue and is exact where there is none", "",
                       ((int Dim), Dim), 2, 3) {
  const NeoHookean material{2, 0.4, 1};
  const auto definite = [&](const Matrix<Dim>& gradient) {
    const auto at = deformation<NeoHookean, Dim>(gradient);
    GradientTangent closed = material.distortional_tangent(at);
    const double rotational = make_definite(closed, at);
    MatrixTangent<Dim> tangent;
    const Matrix<Dim> metric = (at.gradient.transpose() * at.gradient).inverse();  // g_a . g_b = G_a C^-1 G_b
    for (int i = 0; i < Dim; ++i)
      for (int j = 0; j < Dim; ++j)
        for (int k = 0; k < Dim; ++k)
          for (int l = 0; l < Dim; ++l)
            tangent(Dim * j + i, Dim * l + k) =
                (i == k) * (closed.isotropic * (j == l) + rotational * metric(j, l)) +
                closed.exchange * at.inverse_transpose(i, l) * at.inverse_transpose(k, j);
    return tangent;
  };
  const auto smallest = [](const MatrixTangent<Dim>& tangent) {
    return Eigen::SelfAdjointEigenSolver<MatrixTangent<Dim>>(tangent).eigenvalues()[0];
  };
  const Matrix<Dim> swollen = 1.1 * Matrix<Dim>::Identity();
  CHECK_THAT((definite(swollen) - written_out(material, swollen)).norm(), WithinAbs(0, 1e-14));
  std::srand(1);
  int n_indefinite = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const Matrix<Dim> gradient = Matrix<Dim>::Identity() + 0.5 * Matrix<Dim>::Random();
    if (gradient.determinant() < 0.05) continue;
    const auto exact = written_out(material, gradient), kept = definite(gradient);
    n_indefinite += smallest(exact) < -1e-10;
    CHECK(smallest(kept) > -1e-9 * kept.norm());
    CHECK(smallest(kept - exact) > -1e-9 * kept.norm());  // only ever stiffer
    // The generic projection agrees on the sign and is the nearest one, so it changes no more.
    MatrixTangent<Dim> projected = exact;
    make_definite<Dim>(projected);
    CHECK(smallest(projected) > -1e-9 * kept.norm());
    CHECK((projected - exact).norm() <= (kept - exact).norm() + 1e-9 * kept.norm());
  }
  CHECK(n_indefinite > 100);  // or the test would prove nothing
}

TEMPLATE_TEST_CASE_SIG("largest eigenvalue in closed form", "", ((int Dim), Dim), 2, 3) {
  std::srand(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const Matrix<Dim> half = Matrix<Dim>::Random(), a = half + half.transpose();
    const double expected = Eigen::SelfAdjointEigenSolver<Matrix<Dim>>(a).eigenvalues()[Dim - 1];
    CHECK_THAT(largest_eigenvalue<Dim>(a), WithinAbs(expected, 1e-12));
  }
  CHECK(largest_eigenvalue<Dim>(3 * Matrix<Dim>::Identity()) == 3);
}

TEST_CASE("moduli: the relations between them, and what is refused") {
  const double young = 7, poisson = 0.3;
  CHECK_THAT(bulk_modulus(young, poisson),
             WithinRel(lame_modulus(young, poisson) + 2.0 / 3 * shear_modulus(young, poisson), 1e-14));
  CHECK_THAT(contact_modulus(young, poisson), WithinRel(7 / (2 * 0.91), 1e-14));
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  CHECK_NOTHROW((NeoHookean{1, 0.495, 1}.validate()));
  CHECK_NOTHROW((LinearElastic{1, -0.9, 1}.validate()));
  for (const double bad : {0.0, -1.0, nan, infinity}) {
    CHECK_THROWS_WITH((NeoHookean{bad, 0.3, 1}.validate()), contains("young must be positive and finite"));
    CHECK_THROWS_WITH((LinearElastic{1, 0.3, bad}.validate()),
                      contains("density must be positive and finite"));
  }
  for (const double bad : {0.5, 0.6, -1.0, nan, infinity})
    CHECK_THROWS_WITH((NeoHookean{1, bad, 1}.validate()), contains("poisson must lie in (-1, 0.5)"));
}

TEST_CASE("the Material concept: accepted and rejected") {
  STATIC_REQUIRE(Material<Minimal, 3>);
  STATIC_REQUIRE_FALSE(Material<NoVolume, 3>);
  STATIC_REQUIRE_FALSE(Material<Minimal, 2>);
  STATIC_REQUIRE(Material<NeoHookean, 2>);
}
