#include "slave/simulator/camera/painter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <variant>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/mesh/index.h"
#include "slave/simulator/environment/painting.h"
#include "slave/vision/observation.h"

namespace palpate::simulation {
namespace {

using Point = Eigen::Vector2d;

constexpr int kArcPieces = 48;        // of a round tool's end
constexpr double kSmallTriangle = 4;  // [px]; larger ones are drawn in four

// Maps the plane at a distance `behind` z = 0 [m] to the image.
Eigen::Affine2d ImageOfBody(const Camera& camera, const Eigen::Isometry2d& X_SO,
                            double behind = 0) {
  const CameraView view =
      CameraView(camera, camera.size[0], camera.size[1]).Behind(behind, camera.distance);
  const auto image = [&](const Point& p_O) {
    const Point p_S = X_SO * p_O;
    return view.ToImage({p_S.x(), p_S.y(), 0});
  };
  const double unit = camera.pixel;
  Eigen::Affine2d X = Eigen::Affine2d::Identity();
  X.translation() = image({0, 0});
  X.linear().col(0) = (image({unit, 0}) - X.translation()) / unit;
  X.linear().col(1) = (image({0, unit}) - X.translation()) / unit;
  return X;
}

// Returns the true lens of a hand-held scene. The slave does not know its radial distortion of
// third order.
Lens UnknownLens(const Camera& camera, double shift) {
  const double width = camera.size[0], height = camera.size[1];
  const double corner = 0.5 * std::hypot(width, height);  // at 45 degrees from the axis
  return {.fx = corner,
          .fy = corner,
          .cx = 0.5 * (width - 1),
          .cy = 0.5 * (height - 1),
          .distortion = {-shift},
          .size = camera.size};
}

std::optional<LensWarp> LensOf(const Scene& scene) {
  const Camera& camera = *scene.sense.Find<Camera>();
  const double unknown = scene.site.hand ? scene.site.hand->lens : 0;
  if (camera.lens.empty() && unknown != 0) {
    return LensWarp::Distorting(UnknownLens(camera, unknown));
  }
  if (camera.lens.empty()) return std::nullopt;
  const Lens lens = ReadLens(camera.lens);
  if (lens.size != camera.size) {
    throw std::invalid_argument(fmt::format(
        "sense.camera.intrinsics = {}: its images have {} x {} px: expected sense.camera.size, "
        "{} x {}",
        camera.lens.string(), lens.size[0], lens.size[1], camera.size[0], camera.size[1]));
  }
  return LensWarp::Distorting(lens);
}

// Separates these random numbers from others of the seed.
constexpr std::uint32_t kDebrisDraw = 0x6465;
constexpr double kMinDefocus = 0.05;  // smaller ones are not painted [px]

double Between(std::mt19937& random, double least, double most) {
  return least + (most - least) * static_cast<double>(random()) / 4294967296.0;
}

double Wrapped(double x, double length) {
  return x - length * std::floor(x / length);
}

}  // namespace

Painter::Painter(const Scene& scene, const TrueBody& body)
    : true_body_(body),
      size_(scene.sense.Find<Camera>()->size[0], scene.sense.Find<Camera>()->size[1]),
      pixel_(scene.sense.Find<Camera>()->pixel),
      X_IO_(ImageOfBody(*scene.sense.Find<Camera>(), body.X_SO())),
      X_IT_(ImageOfBody(*scene.sense.Find<Camera>(), body.X_SO(),
                        scene.tool->BehindFront(ThicknessOf(scene.object.geometry)))),
      tool_width_(scene.tool->width),
      tool_radius_(scene.tool->shape == Tool::Shape::kRound ? scene.tool->radius : 0),
      tool_O_(body.X_SO().linear().transpose() * scene.tool->direction.normalized()),
      speckle_(Texture::Speckle(scene.site.seed, 3, kBody, kBodyContrast)),
      marks_(Texture::Blotches(scene.site.seed + 1, std::max(3.0, tool_width_ / pixel_ / 4),
                               kToolDark, kToolLight)),
      exposure_(scene.site, scene.sense.Find<Camera>()->size),
      lens_(LensOf(scene)) {
  if (scene.site.hand) hand_.emplace(*scene.site.hand, scene.site.seed);
  if (scene.site.embryo) microscope_.emplace(scene, body, X_IO_, size_);
  if (scene.tool->IsNarrowerThan(ThicknessOf(scene.object.geometry))) PaintSides(scene);
}

// Paints the visible sides around the front face, and the back. They keep their shape at rest.
void Painter::PaintSides(const Scene& scene) {
  const Eigen::Affine2d X_IB = ImageOfBody(*scene.sense.Find<Camera>(), true_body_.X_SO(),
                                           ThicknessOf(scene.object.geometry));
  ground_ = cv::Mat(size_, CV_32F, cv::Scalar(kGround));
  const auto cover = [&](const std::vector<Point>& polygon) {
    const Layer layer(cv::Rect({0, 0}, size_), {polygon}, kSides);
    ground_ += layer.alpha.mul(layer.grey - ground_);
  };
  std::vector<Point> back;
  for (const TrueBody::Edge& e : true_body_.edges()) {
    cover({X_IO_ * e.a, X_IO_ * e.b, X_IB * e.b, X_IB * e.a});
    if (e.loop == 0) back.push_back(X_IB * e.a);
  }
  cover(back);
}

Painter::Layer::Layer(const cv::Rect& part, const std::vector<std::vector<Point>>& polygons,
                      float level)
    : window(part),
      grey(part.size(), CV_32F, cv::Scalar(level)),
      alpha(CoverageOf(polygons, part)) {}

// Nodes of the pressed body's mesh in the image [px].
std::vector<Point> Painter::NodesOf(const Pose& pose) const {
  const PatchSolution& c = *pose.contact;
  std::vector<Point> nodes;
  for (std::size_t i = 0; i < c.mesh.nodes.size(); ++i) {
    const auto u = c.displacement.row(static_cast<Eigen::Index>(i));
    nodes.emplace_back(X_IO_ * (true_body_.larger_side() * c.mesh.nodes[i] +
                                pose.displacement_O.x() * u.head<2>().transpose() +
                                pose.displacement_O.y() * u.tail<2>().transpose()));
  }
  return nodes;
}

void Painter::PaintBody(const Pose& pose) {
  const bool same = !body_.alpha.empty() && pose.contact == painted_.contact &&
                    (!pose.contact || pose.displacement_O == painted_.displacement_O);
  if (same) return;
  painted_ = pose;
  std::vector<std::vector<Point>> loops;
  std::vector<Point> nodes;
  if (pose.contact) {
    const PatchSolution& c = *pose.contact;
    nodes = NodesOf(pose);
    for (std::size_t k = 0; k + 1 < c.loop_begin.size(); ++k) {
      auto& loop = loops.emplace_back();
      for (std::size_t i = c.loop_begin[k]; i < c.loop_begin[k + 1]; ++i) {
        loop.push_back(nodes[Index(c.boundary[i])]);
      }
    }
  } else {
    for (const TrueBody::Edge& e : true_body_.edges()) {
      if (Index(e.loop) == loops.size()) loops.emplace_back();
      loops.back().push_back(X_IO_ * e.a);
    }
  }
  body_ = Layer(cv::Rect({0, 0}, size_), loops, kBody);
  if (pose.contact) {
    FillMesh(pose.contact->mesh, nodes);
  } else {
    const Point rim(2 * pixel_, 2 * pixel_);  // includes the rim pixels whose centres are outside
    const Point low = true_body_.lower_corner() - rim, high = true_body_.upper_corner() + rim;
    const auto on_speckle = [&](const Point& p_O) -> Point { return p_O / pixel_; };
    FillQuad(speckle_, {low, {high.x(), low.y()}, high, {low.x(), high.y()}}, X_IO_, on_speckle,
             &body_);
  }
  if (ground_.empty()) {
    body_alone_ = kGround + body_.alpha.mul(body_.grey - kGround);
  } else {
    body_alone_ = ground_ + body_.alpha.mul(body_.grey - ground_);
  }
}

// `on_texture`: the place of a corner, frame O [m], on the texture [texels].
template <typename OnTexture>
void Painter::FillQuad(const Texture& texture, const std::array<Point, 4>& corners,
                       const Eigen::Affine2d& X_IO, const OnTexture& on_texture,
                       Layer* layer) const {
  const Point shift(layer->window.x, layer->window.y);
  const auto at = [&](const Point& p_O) -> Point { return X_IO * p_O - shift; };
  for (const auto& [i, j, k] : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
    const Point &a = corners[i], &b = corners[j], &c = corners[k];
    texture.Fill(layer->grey, {at(a), at(b), at(c)}, {on_texture(a), on_texture(b), on_texture(c)});
  }
}

void Painter::FillMesh(const QuadraticMesh& mesh, const std::vector<Point>& at) {
  const double texels = true_body_.larger_side() / pixel_;
  const auto fill = [&](int i, int j, int k) {
    const auto a = Index(i), b = Index(j), d = Index(k);
    speckle_.Fill(body_.grey, {at[a], at[b], at[d]},
                  {texels * mesh.nodes[a], texels * mesh.nodes[b], texels * mesh.nodes[d]});
  };
  for (const auto& v : mesh.triangles) {
    const Point &a = at[Index(v[0])], &b = at[Index(v[1])];
    const Point& d = at[Index(v[2])];
    if (std::max((b - a).squaredNorm(), (d - a).squaredNorm()) < kSmallTriangle * kSmallTriangle) {
      fill(v[0], v[1], v[2]);
      continue;
    }
    fill(v[0], v[3], v[5]);
    fill(v[3], v[1], v[4]);
    fill(v[5], v[4], v[2]);
    fill(v[3], v[4], v[5]);
  }
}

// Paints a bar from the tip backwards that is longer than the image.
void Painter::PaintTool(const Pose& pose) {
  const double length =
      pixel_ * (2.0 * (size_.width + size_.height) + (X_IT_ * pose.p_O_tip).norm());
  const Point tool_O = Eigen::Rotation2Dd(pose.tilt) * tool_O_;
  const Point across(-tool_O.y(), tool_O.x());
  // Corners of the bar grown by `rim`, tip end first, and their places on the marks.
  const auto bar = [&](double rim) {
    const Point half = (0.5 * tool_width_ + rim) * across, front = pose.p_O_tip + rim * tool_O;
    const Point back = -(length + rim) * tool_O;
    return std::array<Point, 4>{front - half, front + half, front + half + back,
                                front - half + back};
  };
  const auto on_marks = [&](const Point& p_O) -> Point {
    const Point from_tip = (p_O - pose.p_O_tip) / pixel_;
    return {from_tip.dot(across), -from_tip.dot(tool_O)};
  };
  std::vector<Point> silhouette;
  for (const Point& p : bar(0)) silhouette.push_back(X_IT_ * p);
  if (tool_radius_ > 0) {  // an arc instead of the front edge
    std::vector<Point> arc;
    for (int k = 0; k <= kArcPieces; ++k) {
      const double aside = tool_width_ * (static_cast<double>(k) / kArcPieces - 0.5);
      const double left = std::max(0.0, tool_radius_ * tool_radius_ - aside * aside);
      const double behind = tool_radius_ - std::sqrt(left);
      arc.emplace_back(X_IT_ * (pose.p_O_tip + aside * across - behind * tool_O));
    }
    silhouette.erase(silhouette.begin(), silhouette.begin() + 2);
    silhouette.insert(silhouette.begin(), arc.begin(), arc.end());
  }
  tool_ = Layer(WindowAround(silhouette, 1, size_), {silhouette}, kToolDark);
  // Includes the rim pixels whose centres are outside.
  FillQuad(marks_, bar(2 * pixel_), X_IT_, on_marks, &tool_);
}

// If tool and body share a pixel, they are side by side: their shares add up, and the tool has
// priority if the sum exceeds one. The front face of a thick body hides the tool.
cv::Mat Painter::Join(const Layer& tool) const {
  const cv::Mat alpha = body_.alpha(tool.window), grey = body_.grey(tool.window);
  if (!ground_.empty()) {
    const cv::Mat behind = ground_(tool.window);
    const cv::Mat with_tool = behind + tool.alpha.mul(tool.grey - behind);
    return with_tool + alpha.mul(grey - with_tool);
  }
  const cv::Mat body = cv::min(alpha, 1 - tool.alpha);
  return kGround + body.mul(grey - kGround) + tool.alpha.mul(tool.grey - kGround);
}

cv::Mat Painter::Paint(const Pose& pose) {
  PaintBody(pose);
  PaintTool(pose);
  cv::Mat seen = body_alone_.clone();
  if (!tool_.window.empty()) Join(tool_).copyTo(seen(tool_.window));
  exposure_.Blur(seen);
  exposure_.Advance();
  if (microscope_) microscope_->Show(&seen);
  if (hand_) hand_->Light(pose.t, &seen);
  return exposure_.Expose(lens_ ? lens_->Apply(seen) : seen);
}

Microscope::Microscope(const Scene& scene, const TrueBody& body, const Eigen::Affine2d& X_IO,
                       const cv::Size& size)
    : size_(size), defocus_(scene.site.embryo->defocus), glass_(size, CV_32F, cv::Scalar(1)) {
  for (const Fixed& fixed : scene.object.fixed) {
    if (const auto* arc = std::get_if<FixedArc>(&fixed.where)) {
      PaintCapillary(*arc, 0.5 * body.larger_side(), X_IO);
    }
  }
  Scatter(*scene.site.embryo, scene.site.seed);
}

// Two walls, from the ends of the held arc outwards beyond the image.
void Microscope::PaintCapillary(const FixedArc& arc, double radius, const Eigen::Affine2d& X_IO) {
  const Eigen::Vector2d out(std::cos(arc.centre), std::sin(arc.centre)), aside(-out.y(), out.x());
  const double length = 1e3 * radius;
  for (const double side : {-1.0, 1.0}) {
    const double grip = std::sin(std::min(arc.half_angle, 0.5 * std::numbers::pi)) * radius;
    const double from = std::sqrt(radius * radius - grip * grip);
    const double outer = grip + kWall;
    std::vector<Eigen::Vector2d> wall;
    for (const Eigen::Vector2d& p :
         {Eigen::Vector2d(from, grip), Eigen::Vector2d(length, grip),
          Eigen::Vector2d(length, outer), Eigen::Vector2d(from, outer)}) {
      wall.emplace_back(X_IO * Eigen::Vector2d(p.x() * out + side * p.y() * aside));
    }
    const cv::Rect window = WindowAround(wall, 1, size_);
    if (window.empty()) continue;
    const cv::Mat alpha = CoverageOf({wall}, window);
    cv::Mat part = glass_(window);
    cv::scaleAdd(alpha, kGlass - 1, part, part);
  }
}

void Microscope::Scatter(const EmbryoSite& options, std::uint32_t seed) {
  std::seed_seq sequence{seed, kDebrisDraw};
  std::mt19937 random(sequence);
  for (int i = 0; i < options.debris; ++i) {
    Particle particle;
    particle.p_I = {Between(random, 0, size_.width), Between(random, 0, size_.height)};
    const double speed = Between(random, kSlowest, kFastest);
    const double heading = Between(random, 0, 2 * std::numbers::pi);
    particle.v_I = speed * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    particle.radius = Between(random, 1.5, 5);
    particle.light = static_cast<float>(Between(random, 0.6, 1.1));
    debris_.push_back(particle);
  }
}

// A soft round spot.
void Microscope::Cover(const Particle& particle, cv::Mat* seen) {
  const int reach = static_cast<int>(std::ceil(2.5 * particle.radius));
  const cv::Point middle(static_cast<int>(particle.p_I.x()), static_cast<int>(particle.p_I.y()));
  const cv::Rect box = cv::Rect(middle.x - reach, middle.y - reach, 2 * reach + 1, 2 * reach + 1) &
                       cv::Rect({0, 0}, seen->size());
  for (int y = box.y; y < box.y + box.height; ++y) {
    auto* row = seen->ptr<float>(y);
    for (int x = box.x; x < box.x + box.width; ++x) {
      const double away = (Eigen::Vector2d(x, y) - particle.p_I).squaredNorm();
      const double share = std::exp(-away / (particle.radius * particle.radius));
      row[x] *= 1 - static_cast<float>(share) * (1 - particle.light);
    }
  }
}

void Microscope::Show(cv::Mat* seen) {
  cv::multiply(*seen, glass_, *seen);
  for (Particle& particle : debris_) {
    Cover(particle, seen);
    particle.p_I += particle.v_I;
    particle.p_I.x() = Wrapped(particle.p_I.x(), size_.width);
    particle.p_I.y() = Wrapped(particle.p_I.y(), size_.height);
  }
  const double phase = 2 * std::numbers::pi * static_cast<double>(images_++) / kFocusPeriod;
  const double sigma = defocus_ * 0.5 * (1 - std::cos(phase));
  if (sigma > kMinDefocus) cv::GaussianBlur(*seen, *seen, {}, sigma);
}

}  // namespace palpate::simulation
