// SPDX-License-Identifier: MIT
#include <jampack/law/friction_cone.hpp>
#include <jampack/law/hertz_check.hpp>
#include <jampack/law/signorini.hpp>
#include <random>

#include "../catch.hpp"

using namespace jampack;

TEMPLATE_TEST_CASE_SIG("Projection on the friction cone is a member, idempotent and orthogonal", "",
                       ((int N), N), 1, 2, 3) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> exponent(-3, 1);
  for (int k = 0; k < 100000; ++k) {
    ContactVector<N> z;
    for (int i = 0; i < N; ++i) z[i] = normal(random);
    const double friction = k % 7 == 0 ? 0 : std::pow(10, exponent(random));
    const ContactVector<N> r = project_on_friction_cone<N>(z, friction);
    const ContactVector<N> again = project_on_friction_cone<N>(r, friction);
    REQUIRE(in_friction_cone<N>(r, friction, 1e-14));
    REQUIRE((again - r).norm() <= 1e-14);
    // Moreau: z = r + polar part, the two orthogonal, and -polar in the dual cone.
    REQUIRE(std::abs(r.dot(z - r)) <= 1e-13 * z.squaredNorm());
    REQUIRE(in_dual_cone<N>(ContactVector<N>(r - z), friction, 1e-13));
  }
}

TEST_CASE("De Saxce's velocity of a sliding contact is orthogonal to its reaction") {
  const double friction = 0.3;
  const ContactVector<3> u(0, 0.4, -0.3), r(2, -0.6 * 0.8, 0.6 * 0.6);
  CHECK(std::abs(de_saxce_velocity<3>(u, friction).dot(r)) < 1e-15);
}

TEST_CASE("HertzCheck: a contact's compliance inverts its force law") {
  const HertzCheck law{.young = 3, .poisson = 0.3};
  const double h = 0.01, modulus = law.modulus_of_two_grains(), radius = 0.25, delta = 0.02;
  const CompliantContact sphere = law.contact<3>(modulus, radius, h);
  const double impulse = h * law.force<3>(modulus, radius, delta);
  CHECK_THAT(h * sphere.compliance(impulse), Catch::Matchers::WithinRel(delta, 1e-12));
  const CompliantContact disk = law.contact<2>(modulus, radius, h);
  CHECK_THAT(h * disk.compliance(h * law.force<2>(modulus, radius, delta)),
             Catch::Matchers::WithinRel(delta, 1e-12));
  const double step = 1e-6 * impulse;
  CHECK_THAT(sphere.compliance_slope(impulse),
             Catch::Matchers::WithinRel(
                 (sphere.compliance(impulse + step) - sphere.compliance(impulse - step)) / (2 * step), 1e-6));
  CHECK_THROWS_AS(law.contact<3>(0, radius, h), InvalidInput);
}

TEST_CASE("Laws carry the unknowns they need") {
  STATIC_REQUIRE(n_contact_unknowns<Signorini, 2> == 1);
  STATIC_REQUIRE(n_contact_unknowns<Signorini, 3> == 1);
  STATIC_REQUIRE(n_contact_unknowns<HertzCheck, 3> == 1);
}
