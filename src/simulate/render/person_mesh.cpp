#include "simulate/render/person_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "extperfc/base/math.hpp"

#include "simulate/render/face_texture.hpp"
#include "simulate/render/head_mesh.hpp"

namespace extperfc::simulate {

namespace {

using Eigen::Vector3f;

constexpr int kCorners = 16;  // of a cross-section
constexpr int kSteps = 3;     // cross-sections from one given one to the next

/// An elliptic cross-section of a limb.
struct Section {
  Vector3f centre;
  float side;   ///< half width to the left and right [m]
  float front;  ///< half width across that and across the limb [m]
};

template <typename T>
T spline(const T& before, const T& from, const T& to, const T& after, float t) {
  const T a = 0.5F * (to - before);
  const T b = 0.5F * (after - from);
  const float t2 = t * t;
  const float t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * from + (t3 - 2 * t2 + t) * a + (3 * t2 - 2 * t3) * to + (t3 - t2) * b;
}

/// Catmull-Rom spline through the given cross-sections.
std::vector<Section> refine(const std::vector<Section>& given) {
  std::vector<Section> all;
  const auto last = given.size() - 1;
  for (std::size_t i = 0; i < last; ++i) {
    const Section& p = given[i > 0 ? i - 1 : 0];
    const Section& n = given[std::min(i + 2, last)];
    for (int k = 0; k < kSteps; ++k) {
      const float t = static_cast<float>(k) / kSteps;
      all.push_back({spline<Vector3f>(p.centre, given[i].centre, given[i + 1].centre, n.centre, t),
                     std::max(0.0F, spline(p.side, given[i].side, given[i + 1].side, n.side, t)),
                     std::max(0.0F, spline(p.front, given[i].front, given[i + 1].front, n.front, t))});
    }
  }
  all.push_back(given.back());
  return all;
}

/// Area-weighted normals of rows of kCorners + 1 vertices whose first and last are one place.
void smooth(Mesh& mesh) {
  for (auto& vertex : mesh.vertices) vertex.normal.setZero();
  for (const auto& triangle : mesh.triangles) {
    const Vector3f& a = mesh.vertices[triangle.corners[0]].position;
    const Vector3f& b = mesh.vertices[triangle.corners[1]].position;
    const Vector3f& c = mesh.vertices[triangle.corners[2]].position;
    for (const auto corner : triangle.corners) mesh.vertices[corner].normal += (b - a).cross(c - a);
  }
  for (std::size_t i = 0; i + kCorners < mesh.vertices.size(); i += kCorners + 1) {
    const Vector3f seam = mesh.vertices[i].normal + mesh.vertices[i + kCorners].normal;
    mesh.vertices[i].normal = mesh.vertices[i + kCorners].normal = seam;
  }
  for (auto& vertex : mesh.vertices) {
    const float length = vertex.normal.norm();
    vertex.normal = length > 0 ? Vector3f(vertex.normal / length) : Vector3f::UnitZ();
  }
}

/// A closed tube through cross-sections; the first and the last are drawn to a point.
Mesh tube(const std::vector<Section>& given, std::uint32_t surface) {
  auto sections = refine(given);
  Section first = sections.front();
  Section last = sections.back();
  first.side = first.front = last.side = last.front = 0.0F;
  sections.insert(sections.begin(), first);
  sections.push_back(last);
  Mesh mesh;
  float along = 0;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const auto& section = sections[i];
    const Vector3f step =
        sections[std::min(i + 1, sections.size() - 1)].centre - sections[i > 0 ? i - 1 : 0].centre;
    const Vector3f axis = step.normalized();
    const Vector3f side = (Vector3f::UnitY() - axis.y() * axis).normalized();
    const Vector3f front = side.cross(axis);
    if (i > 0) along += (section.centre - sections[i - 1].centre).norm();
    for (int k = 0; k <= kCorners; ++k) {
      const float angle = kTwoPiF * static_cast<float>(k) / kCorners;
      mesh.vertices.push_back({section.centre + front * (section.front * std::cos(angle)) +
                                   side * (section.side * std::sin(angle)),
                               Vector3f::Zero(),
                               {angle * 0.08F, along}});
    }
  }
  constexpr std::uint32_t kRow = kCorners + 1;
  for (std::uint32_t i = 1; i < sections.size(); ++i)
    join_rows(mesh, (i - 1) * kRow, i * kRow, kRow, surface);
  mesh.drop_slivers();
  smooth(mesh);
  return mesh;
}

Mesh ellipsoid(const Vector3f& centre, float front, float side, float up, std::uint32_t surface) {
  std::vector<Section> sections;
  for (const float t : {-0.96F, -0.7F, -0.3F, 0.15F, 0.6F, 0.88F, 0.985F}) {
    const float r = std::sqrt(1 - t * t);
    sections.push_back({centre + Vector3f(0, 0, t * up), side * r, front * r});
  }
  return tube(sections, surface);
}

class Figure {
 public:
  explicit Figure(const PersonSurfaces& surfaces) : surfaces_(surfaces) {}

  void add(PersonPart part, const std::vector<Section>& sections) { add(tube(sections, surface(part))); }
  void add(const Mesh& mesh) { mesh_.append(mesh, Eigen::Isometry3f::Identity()); }
  [[nodiscard]] std::uint32_t surface(PersonPart part) const {
    return surfaces_[static_cast<std::size_t>(part)];
  }
  Mesh take() { return std::move(mesh_); }

 private:
  PersonSurfaces surfaces_;
  Mesh mesh_;
};

void add_trunk(Figure& figure) {
  figure.add(PersonPart::kShirt, {{{0, 0, 0.88F}, 0.170F, 0.118F},
                                  {{0, 0, 0.96F}, 0.172F, 0.120F},
                                  {{0, 0, 1.08F}, 0.155F, 0.108F},
                                  {{0, 0, 1.25F}, 0.178F, 0.120F},
                                  {{0, 0, 1.36F}, 0.192F, 0.112F},
                                  {{-0.005F, 0, 1.425F}, 0.170F, 0.088F},
                                  {{-0.008F, 0, 1.465F}, 0.105F, 0.070F},
                                  {{-0.006F, 0, 1.495F}, 0.062F, 0.060F}});
  figure.add(
      PersonPart::kTrousers,
      {{{0, 0, 0.80F}, 0.120F, 0.085F}, {{0, 0, 0.86F}, 0.163F, 0.112F}, {{0, 0, 0.95F}, 0.160F, 0.108F}});
}

void add_neck(Figure& figure) {
  figure.add(PersonPart::kSkin, {{{-0.006F, 0, 1.46F}, 0.056F, 0.054F},
                                 {{-0.008F, 0, 1.50F}, 0.049F, 0.050F},
                                 {{-0.008F, 0, 1.54F}, 0.046F, 0.050F},
                                 {{-0.006F, 0, 1.59F}, 0.046F, 0.052F}});
}

/// The outline of an ear is a little wider above.
void add_ears(Figure& figure, const FaceFeatures& face) {
  const float half = face.head_half_width_m;
  for (const float side : {-1.0F, 1.0F})
    figure.add(PersonPart::kSkin, {{{0.004F, side * (half - 0.003F), 1.615F}, 0.006F, 0.006F},
                                   {{0.001F, side * (half - 0.001F), 1.628F}, 0.008F, 0.012F},
                                   {{-0.004F, side * (half + 0.003F), 1.650F}, 0.009F, 0.017F},
                                   {{-0.006F, side * (half + 0.004F), 1.664F}, 0.008F, 0.014F},
                                   {{-0.006F, side * (half + 0.002F), 1.672F}, 0.005F, 0.008F}});
}

/// Hair that hangs or is bound; the rest is part of the head.
void add_long_hair(Figure& figure, const FaceFeatures& face) {
  const float half = face.head_half_width_m;
  if (face.hair_style == HairStyle::kLong)
    figure.add(PersonPart::kHair, {{{-0.040F, 0, 1.690F}, half, 0.050F},
                                   {{-0.048F, 0, 1.620F}, half + 0.012F, 0.052F},
                                   {{-0.056F, 0, 1.540F}, half + 0.014F, 0.046F},
                                   {{-0.072F, 0, 1.460F}, half + 0.012F, 0.036F},
                                   {{-0.086F, 0, 1.390F}, half - 0.006F, 0.026F}});
  if (face.hair_style == HairStyle::kBun)
    figure.add(ellipsoid({-0.098F, 0, 1.735F}, 0.038F, 0.038F, 0.034F, figure.surface(PersonPart::kHair)));
}

void add_head(Figure& figure, const FaceFeatures& face) {
  add_neck(figure);
  figure.add(make_head(HeadShape(face), figure.surface(PersonPart::kHead)));
  if (face.hair_style != HairStyle::kLong) add_ears(figure, face);
  add_long_hair(figure, face);
}

/// From the hip over the knee to the ankle, then the shoe.
void add_leg(Figure& figure, float y, const Vector3f& knee, const Vector3f& ankle, float toe_down) {
  const Vector3f hip(0, y, 0.90F);
  const auto between = [](const Vector3f& a, const Vector3f& b, float t) {
    return Vector3f(a + t * (b - a));
  };
  figure.add(PersonPart::kTrousers, {{hip, 0.088F, 0.100F},
                                     {between(hip, knee, 0.35F), 0.082F, 0.090F},
                                     {between(hip, knee, 0.75F), 0.066F, 0.068F},
                                     {knee, 0.059F, 0.062F},
                                     {between(knee, ankle, 0.3F) - Vector3f(0.012F, 0, 0), 0.058F, 0.064F},
                                     {between(knee, ankle, 0.75F), 0.050F, 0.054F},
                                     {ankle, 0.052F, 0.060F}});
  const Vector3f heel = ankle + Vector3f(-0.055F, 0, -0.045F + 0.3F * toe_down);
  const Vector3f toe = ankle + Vector3f(0.185F, 0, -0.055F - toe_down);
  figure.add(PersonPart::kShoes, {{heel, 0.028F, 0.034F},
                                  {between(heel, toe, 0.10F), 0.036F, 0.042F},
                                  {between(heel, toe, 0.30F), 0.038F, 0.050F},
                                  {between(heel, toe, 0.55F), 0.043F, 0.040F},
                                  {between(heel, toe, 0.85F), 0.045F, 0.029F},
                                  {toe, 0.030F, 0.020F}});
}

void add_arm(Figure& figure, const Vector3f& shoulder, const Vector3f& elbow, const Vector3f& wrist) {
  const auto between = [](const Vector3f& a, const Vector3f& b, float t) {
    return Vector3f(a + t * (b - a));
  };
  const Vector3f inwards(0, shoulder.y() > 0 ? -0.05F : 0.05F, 0.015F);
  figure.add(PersonPart::kShirt, {{shoulder + inwards, 0.050F, 0.060F},
                                  {shoulder, 0.056F, 0.062F},
                                  {between(shoulder, elbow, 0.4F), 0.052F, 0.056F},
                                  {elbow, 0.044F, 0.048F},
                                  {between(elbow, wrist, 0.5F), 0.040F, 0.043F},
                                  {wrist, 0.034F, 0.036F}});
  const Vector3f along = (wrist - elbow).normalized();
  figure.add(PersonPart::kSkin, {{wrist - 0.02F * along, 0.024F, 0.029F},
                                 {wrist + 0.02F * along, 0.022F, 0.034F},
                                 {wrist + 0.07F * along, 0.022F, 0.043F},
                                 {wrist + 0.12F * along, 0.018F, 0.036F},
                                 {wrist + 0.16F * along, 0.011F, 0.020F}});
}

}  // namespace

Mesh make_person(const PersonSurfaces& surfaces, const FaceFeatures& face) {
  Figure figure(surfaces);
  add_trunk(figure);
  add_head(figure, face);
  add_leg(figure, 0.090F, {0.150F, 0.088F, 0.50F}, {0.215F, 0.085F, 0.095F}, 0.0F);
  add_leg(figure, -0.090F, {-0.010F, -0.088F, 0.50F}, {-0.235F, -0.085F, 0.150F}, 0.060F);
  add_arm(figure, {-0.005F, -0.200F, 1.395F}, {0.020F, -0.245F, 1.125F}, {0.170F, -0.225F, 0.945F});
  add_arm(figure, {-0.005F, 0.200F, 1.395F}, {-0.110F, 0.240F, 1.140F}, {-0.100F, 0.240F, 0.890F});
  return figure.take();
}

Material person_material(PersonPart part, const Eigen::Vector3f& clothes, std::uint32_t number,
                         const FaceFeatures& face) {
  static const std::array<Eigen::Vector3f, 4> kTrousers{
      {{0.24F, 0.30F, 0.42F}, {0.22F, 0.22F, 0.24F}, {0.55F, 0.49F, 0.39F}, {0.30F, 0.27F, 0.24F}}};
  switch (part) {
    case PersonPart::kSkin:
      return {{face.skin.r, face.skin.g, face.skin.b}, Texture::kNone, 1.0F, 0.06F};
    case PersonPart::kHair:
      return {{face.hair.r, face.hair.g, face.hair.b}, Texture::kNone, 1.0F, 0.10F};
    case PersonPart::kHead:
      return {{1, 1, 1}, Texture::kNone, kFaceTextureSize_m, 0.06F};
    case PersonPart::kShirt:
      return {clothes, Texture::kCloth, 0.30F, 0.0F};
    case PersonPart::kTrousers:
      return {kTrousers[(number + 1) % 4], Texture::kCloth, 0.25F, 0.0F};
    case PersonPart::kShoes:
      break;
  }
  return {{0.16F, 0.14F, 0.13F}, Texture::kNone, 1.0F, 0.25F};
}

}  // namespace extperfc::simulate
