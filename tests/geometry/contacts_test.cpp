#include "orasp/geometry/contacts.h"

#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "orasp/geometry/detail/part_names.h"
#include "orasp/geometry/detail/triangle_tree.h"
#include "orasp/model/random.h"
#include "tests/geometry/made_cases.h"
#include "tests/seeds.h"

namespace orasp {
namespace {

using shapes::block;
using shapes::part;

std::vector<Contact> contacts_of(const std::vector<CadPart>& parts, double tolerance = 0.1,
                                 unsigned threads = 1) {
  GeometrySettings settings;
  settings.tolerance = tolerance;
  settings.threads = threads;
  return find_contacts(parts, settings);
}

Contact contact_of(const Mesh& a, const Mesh& b, double tolerance = 0.1) {
  const std::vector<Contact> contacts = contacts_of({part(a), part(b)}, tolerance);
  EXPECT_EQ(contacts.size(), 1U);
  return contacts.empty() ? Contact{} : contacts[0];
}

TEST(FindContacts, MeasuresTheAreaOfFacesThatLieOnOneAnother) {
  const Contact contact =
      contact_of(block({0, 0, 0}, {10, 10, 10}), block({4, 3, 10}, {20, 8, 12}));
  EXPECT_FALSE(contact.proposed);
  EXPECT_EQ(contact.kind, Contact::Kind::Touch);
  EXPECT_NEAR(contact.distance, 0, 1e-9);
  EXPECT_NEAR(contact.area, 6 * 5, 1e-9);
  EXPECT_FALSE(contact.overlap.has_value());
}

TEST(FindContacts, TakesAGapUpToTheTolerance) {
  const Mesh a = block({0, 0, 0}, {10, 10, 10});
  const Contact near = contact_of(a, block({4, 3, 10.08}, {20, 8, 12}));
  EXPECT_FALSE(near.proposed);
  EXPECT_NEAR(near.distance, 0.08, 1e-9);
  EXPECT_NEAR(near.area, 30, 1e-9);
  const Contact far = contact_of(a, block({4, 3, 10.12}, {20, 8, 12}));
  EXPECT_TRUE(far.proposed);
  EXPECT_NEAR(far.distance, 0.12, 1e-9);
  EXPECT_EQ(far.area, 0);
}

TEST(FindContacts, CountsOfATiltedFaceOnlyWhatIsNear) {
  // A wedge that leaves the face by one in fifty: 0.1 away after 5.
  const Mesh wedge =
      shapes::laid_along_y(shapes::extruded({{0, 10}, {10, 10.2}, {10, 14}, {0, 14}}, -8, -3));
  const Contact contact = contact_of(block({0, 0, 0}, {10, 10, 10}), wedge);
  EXPECT_NEAR(contact.area, 5 * 5, 0.05);
}

TEST(FindContacts, DoesNotCountFacesThatLookTheSameWay) {
  // Side by side, flush on top: 10 x 10 between them.
  const Contact contact =
      contact_of(block({0, 0, 0}, {10, 10, 10}), block({10, 0, 0}, {20, 10, 10}));
  EXPECT_NEAR(contact.area, 100, 1e-9);
}

TEST(FindContacts, MeasuresTheWallOfARoundHole) {
  const Mesh peg = shapes::cylinder(5, -5, 15, 60);
  const Contact contact = contact_of(peg, shapes::tube(5, 9, 0, 10, 75, 0.04));
  EXPECT_NEAR(contact.area, 2 * std::numbers::pi * 5 * 10, 6);
  EXPECT_EQ(contact.kind, Contact::Kind::Fit);
  EXPECT_FALSE(contact.overlap.has_value());  // the triangles overlap, by less than the tolerance
}

TEST(FindContacts, MeasuresOverlaps) {
  const Contact flat = contact_of(block({0, 0, 0}, {10, 10, 10}), block({2, 3, 9.7}, {8, 20, 15}));
  ASSERT_TRUE(flat.overlap.has_value());
  EXPECT_EQ(flat.distance, 0);
  EXPECT_NEAR(flat.overlap->volume, 6 * 7 * 0.3, 0.2);
  EXPECT_NEAR(flat.overlap->thickness, 0.3, 0.01);
  EXPECT_NEAR(flat.overlap->share, flat.overlap->volume / (6 * 17 * 5.3), 1e-9);

  const Contact ring = contact_of(shapes::cylinder(2.3, 0, 10, 80), shapes::tube(2, 9, -3, 8, 90));
  ASSERT_TRUE(ring.overlap.has_value());
  EXPECT_EQ(ring.kind, Contact::Kind::Fit);
  EXPECT_NEAR(ring.overlap->volume, std::numbers::pi * (2.3 * 2.3 - 4) * 8, 1.0);
  EXPECT_NEAR(ring.overlap->thickness, 0.3, 0.02);
}

TEST(FindContacts, MeasuresOverlapsThatLieAskew) {
  const Contact contact = contact_of(shapes::moved(shapes::cylinder(2.3, 0, 10, 80), shapes::askew),
                                     shapes::moved(shapes::tube(2, 9, -3, 8, 90), shapes::askew));
  ASSERT_TRUE(contact.overlap.has_value());
  EXPECT_NEAR(contact.overlap->volume, std::numbers::pi * (2.3 * 2.3 - 4) * 8, 1.5);
  EXPECT_NEAR(contact.overlap->thickness, 0.3, 0.04);
}

TEST(FindContacts, FindsAPartDrawnInsideOfAnother) {
  const Contact contact = contact_of(block({0, 0, 0}, {10, 10, 10}), block({2, 2, 2}, {5, 5, 5}));
  ASSERT_TRUE(contact.overlap.has_value());
  EXPECT_FALSE(contact.proposed);
  EXPECT_NEAR(contact.overlap->volume, 27, 0.7);
  EXPECT_NEAR(contact.overlap->share, 1, 0.03);
  EXPECT_NEAR(contact.overlap->thickness, 3, 0.1);
}

TEST(FindContacts, ProposesTheNearestForAPartThatTouchesNothing) {
  // 0 and 1 touch; 2 is 3 from 1 and 5 from 3; 3 is nearest to 2.
  const std::vector<Contact> contacts =
      contacts_of({part(block({0, 0, 0}, {1, 1, 1})), part(block({1, 0, 0}, {2, 1, 1})),
                   part(block({5, 0, 0}, {6, 1, 1})), part(block({11, 0, 0}, {12, 1, 1}))});
  ASSERT_EQ(contacts.size(), 3U);
  EXPECT_EQ(std::tuple(contacts[0].a, contacts[0].b, contacts[0].proposed),
            std::tuple(0U, 1U, false));
  EXPECT_EQ(std::tuple(contacts[1].a, contacts[1].b, contacts[1].proposed),
            std::tuple(1U, 2U, true));
  EXPECT_NEAR(contacts[1].distance, 3, 1e-12);
  EXPECT_EQ(std::tuple(contacts[2].a, contacts[2].b, contacts[2].proposed),
            std::tuple(2U, 3U, true));
  EXPECT_NEAR(contacts[2].distance, 5, 1e-12);
}

TEST(FindContacts, ProposesOnePairOnce) {
  const auto contacts =
      contacts_of({part(block({0, 0, 0}, {1, 1, 1})), part(block({5, 0, 0}, {6, 1, 1}))});
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_TRUE(contacts[0].proposed);
}

TEST(FindContacts, KnowsFastenersByTheirNames) {
  for (const char* name :
       {"M3x30 SHCS", "Low Profile Screw M5_M5 x 20", "Nylon Insert Lock Nut M5", "DIN 912 - 8.8",
        "ISO4762 M4", "HexBolt", "Washer", "rivet_4", "Dowel Pin", "bolts", "T-Nut", "M2.5x8"}) {
    EXPECT_TRUE(detail::names_fastener(name)) << name;
  }
  for (const char* name : {"", "Ball Bearing 5 x 16 x 5", "Pinion", "Lead Screw 8mm", "Nut Block",
                           "Screw Holder 2", "M3-plate", "Coconut", "Dining table", "Spindle",
                           "Eccentric Spacer 6mm", "Pin Header 2x4", "M5 Spacer"}) {
    EXPECT_FALSE(detail::names_fastener(name)) << name;
  }
}

TEST(FindContacts, TellsFastenersAndFits) {
  const auto contacts = contacts_of({part(block({0, 0, 0}, {10, 10, 10}), "Plate"),
                                     part(block({0, 0, 10}, {10, 10, 11}), "Washer"),
                                     part(block({0, 0, 11}, {10, 10, 20}), "Lid")});
  ASSERT_EQ(contacts.size(), 2U);
  EXPECT_EQ(contacts[0].kind, Contact::Kind::Fastener);
  EXPECT_EQ(contacts[1].kind, Contact::Kind::Fastener);
  for (const auto& made : shapes::made_cases()) {
    const auto found = contacts_of({part(made.a), part(made.b)}, made.tolerance);
    ASSERT_EQ(found.size(), 1U) << made.name;
    // The ball is held all round by narrow rings of triangles only, or not quite.
    if (made.name.find("socket") != std::string::npos) continue;
    const bool fit = made.name.starts_with("peg") || made.name.starts_with("press") ||
                     made.name.starts_with("heat") || made.name.starts_with("M3") ||
                     made.name == "dovetail" || made.name == "ring in a groove";
    EXPECT_EQ(found[0].kind == Contact::Kind::Fit, fit) << made.name;
  }
}

TEST(FindContacts, TakesWhatTheDrawingSaysOfRoundFaces) {
  CadPart peg = part(shapes::cylinder(5, 0, 10, 40));
  CadPart hole = part(shapes::tube(5, 9, 0, 10, 43));
  FaceHint face;
  face.kind = FaceHint::Kind::Cylinder;
  face.direction = {0, 0, 1};
  face.radius = 5;
  peg.faces = {face};
  face.point = {0, 0, 7};
  face.hollow = true;
  hole.faces = {face};
  EXPECT_EQ(contacts_of({peg, hole})[0].kind, Contact::Kind::Fit);
  hole.faces[0].radius = 5.2;  // a bore with play
  EXPECT_EQ(contacts_of({peg, hole})[0].kind, Contact::Kind::Touch);
}

TEST(FindContacts, IsTheSameForAnyNumberOfThreads) {
  std::vector<CadPart> parts;
  SplitMix64 random(5);
  for (int i = 0; i < 8 + some_of(16); ++i) {
    const Vector3 at = {random.uniform() * 30, random.uniform() * 20, random.uniform() * 10};
    parts.push_back(part(shapes::shifted(shapes::cylinder(3, 0, 4, 20), at)));
  }
  const auto one = contacts_of(parts, 0.1, 1);
  ASSERT_GE(one.size(), 4U);  // of the few that a sanitizer looks at too
  for (const unsigned threads : {2U, 5U}) {
    const auto more = contacts_of(parts, 0.1, threads);
    ASSERT_EQ(more.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(std::tuple(one[i].a, one[i].b, one[i].distance, one[i].area, one[i].kind),
                std::tuple(more[i].a, more[i].b, more[i].distance, more[i].area, more[i].kind));
      EXPECT_EQ(one[i].overlap ? one[i].overlap->volume : 0,
                more[i].overlap ? more[i].overlap->volume : 0);
    }
  }
}

TEST(FindContacts, TakesNoPartsAndNoTriangles) {
  EXPECT_TRUE(contacts_of({}).empty());
  EXPECT_TRUE(contacts_of({part(Mesh{}), part(Mesh{})}).empty());
  EXPECT_TRUE(contacts_of({part(Mesh{}), part(block({0, 0, 0}, {1, 1, 1}))}).empty());
}

// The distance of two triangles by looking at a lattice of points of the one.
TEST(TriangleDistance, IsNotAboveThatOfAnyTwoPoints) {
  SplitMix64 random(17);
  const auto point = [&] { return Vector3{random.uniform(), random.uniform(), random.uniform()}; };
  for (int round = 0; round < some_of(60); ++round) {
    const detail::Corners a = {point(), point(), point()};
    detail::Corners b = {point(), point(), point()};
    if (round % 2 == 0) {
      for (Vector3& p : b) p[2] += 1.2;
    }
    constexpr int kSteps = 24;
    const auto at = [&](const detail::Corners& c, int i, int j) {
      const double s = static_cast<double>(i) / kSteps;
      const double t = static_cast<double>(j) / kSteps * (1 - s);
      return detail::plus(detail::times(c[0], 1 - s - t),
                          detail::plus(detail::times(c[1], s), detail::times(c[2], t)));
    };
    double nearest = 1e300;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; j <= kSteps; ++j) {
        for (int k = 0; k <= kSteps; ++k) {
          for (int l = 0; l <= kSteps; ++l) {
            const Vector3 gap = detail::minus(at(a, i, j), at(b, k, l));
            nearest = std::min(nearest, detail::dot(gap, gap));
          }
        }
      }
    }
    const double found = detail::squared_distance(a, b);
    EXPECT_LE(found, nearest + 1e-12) << round;
    EXPECT_NEAR(std::sqrt(found), std::sqrt(nearest), 0.05) << round;
  }
}

TEST(TriangleTree, KnowsInsideFromOutside) {
  const Mesh mesh = shapes::tube(2, 4, 0, 3, 50);
  const detail::TriangleTree tree(mesh);
  EXPECT_TRUE(detail::contains(tree, {3, 0.1, 1}));
  EXPECT_FALSE(detail::contains(tree, {0.1, 0.1, 1}));
  EXPECT_FALSE(detail::contains(tree, {3, 0.1, -1}));
  EXPECT_FALSE(detail::contains(tree, {5, 5, 1}));
  EXPECT_NEAR(detail::distance_above(tree, {0, 0, 1.5}, 0), 1.5, 1.5);
}

}  // namespace
}  // namespace orasp
