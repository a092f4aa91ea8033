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

#include "shared/geometry/index.h"
#include "slave/simulator/environment/painting.h"
#include "slave/vision/observation.h"

namespace palpate::site {
namespace {

using Point = Eigen::Vector2d;

constexpr int kArcPieces = 48;        // of a round tool's end
constexpr double kSmallTriangle = 4;  // [px]; larger ones are drawn in four

const Camera& CameraOf(const Scene& scene) {
  if (!scene.sense.Find<Camera>()) {
    throw std::invalid_argument("sense.camera: missing; the simulator needs a camera");
  }
  const Camera& camera = *scene.sense.Find<Camera>();
  if (camera.size[0] < 16 || camera.size[1] < 16 || camera.size[0] > 16384 ||
      camera.size[1] > 16384) {
    throw std::invalid_argument("sense.camera.size = [" + std::to_string(camera.size[0]) + ", " +
                                std::to_string(camera.size[1]) +
                                "]: accepted by the simulator is 16 to 16384 px each");
  }
  if (!(camera.pixel > 0)) {
    throw std::invalid_argument("sense.camera.pixel = " + std::to_string(camera.pixel) +
                                " m: accepted is > 0");
  }
  return camera;
}

Eigen::Affine2d ImageOfBody(const Camera& camera, const Eigen::Isometry2d& X_SO) {
  const CameraView view(camera, camera.size[0], camera.size[1]);
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

std::optional<LensWarp> LensOf(const Camera& camera) {
  if (camera.lens.empty()) return std::nullopt;
  const Lens lens = ReadLens(camera.lens);
  if (lens.size != camera.size) {
    throw std::invalid_argument(fmt::format(
        "sense.camera.intrinsics = {}: its images have {} x {} px: accepted is sense.camera.size, "
        "{} x {}",
        camera.lens.string(), lens.size[0], lens.size[1], camera.size[0], camera.size[1]));
  }
  return LensWarp::Distorting(lens);
}

constexpr std::uint32_t kDebrisDraw = 0x6465;  // apart from what else the seed draws
constexpr double kLeastDefocus = 0.05;         // less is none [px]

double Between(std::mt19937& random, double least, double most) {
  return least + (most - least) * static_cast<double>(random()) / 4294967296.0;
}

double Wrapped(double x, double length) {
  return x - length * std::floor(x / length);
}

}  // namespace

Painter::Painter(const Scene& scene, const TrueBody& body)
    : body_(body),
      size_(CameraOf(scene).size[0], CameraOf(scene).size[1]),
      pixel_(scene.sense.Find<Camera>()->pixel),
      X_IO_(ImageOfBody(*scene.sense.Find<Camera>(), body.X_SO())),
      tool_width_(scene.tool->width),
      tool_radius_(scene.tool->shape == Tool::Shape::kRound ? scene.tool->radius : 0),
      tool_O_(body.X_SO().linear().transpose() * scene.tool->direction.normalized()),
      speckle_(Texture::Speckle(scene.site.seed, 3, kBody, kBodyContrast)),
      marks_(Texture::Blotches(scene.site.seed + 1, std::max(3.0, tool_width_ / pixel_ / 4),
                               kToolDark, kToolLight)),
      exposure_(scene.site, scene.sense.Find<Camera>()->size),
      seen_(size_, CV_32F, cv::Scalar(kGround)),
      lens_(LensOf(*scene.sense.Find<Camera>())) {
  if (scene.site.embryo) microscope_.emplace(scene, body, X_IO_, size_);
}

// The body's loops in the picture [px], deformed if there is a contact.
std::vector<std::vector<Point>> Painter::BodyLoops(const Pose& pose) const {
  std::vector<std::vector<Point>> loops;
  if (!pose.contact) {
    for (const TrueBody::Edge& e : body_.edges()) {
      if (Index(e.loop) == loops.size()) loops.emplace_back();
      loops.back().push_back(X_IO_ * e.a);
    }
    return loops;
  }
  const PatchSolution& c = *pose.contact;
  for (std::size_t k = 0; k + 1 < c.loop_begin.size(); ++k) {
    auto& loop = loops.emplace_back();
    for (std::size_t i = c.loop_begin[k]; i < c.loop_begin[k + 1]; ++i) {
      const auto u = c.displacement.row(c.boundary[i]);
      const Point moved = pose.displacement_O.x() * u.head<2>().transpose() +
                          pose.displacement_O.y() * u.tail<2>().transpose();
      const Point rest = body_.larger_side() * c.mesh.nodes[Index(c.boundary[i])];
      loop.push_back(X_IO_ * (rest + moved));
    }
  }
  return loops;
}

void Painter::PaintBody(const Pose& pose) {
  const bool same = body_painted_ && pose.contact == painted_.contact &&
                    (!pose.contact || pose.displacement_O == painted_.displacement_O);
  if (same) return;
  const auto loops = BodyLoops(pose);
  Layer& layer = body_layer_;
  layer.window = WindowAround(loops.front(), 1, size_);
  if (!layer.window.empty()) {
    Coverage coverage(layer.window);
    for (const auto& loop : loops) coverage.Add(loop);
    coverage.Resolve(layer.alpha);
    // Rim pixels whose centre lies outside keep the mean grey.
    layer.grey.create(layer.window.size(), CV_32F);
    layer.grey.setTo(kBody);
    if (pose.contact) {
      FillBodyDeformed(pose);
    } else {
      FillBodyAtRest();
    }
  }
  painted_ = pose;
  body_painted_ = true;
}

void Painter::FillBodyAtRest() {
  const Point rim(2 * pixel_, 2 * pixel_);  // reaches the rim pixels whose centres lie outside
  const Point low = body_.lower_corner() - rim, high = body_.upper_corner() + rim;
  const std::array<Point, 4> corner{low, Point(high.x(), low.y()), high, Point(low.x(), high.y())};
  for (const auto& [i, j, k] : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
    speckle_.Fill(body_layer_.grey, body_layer_.window.tl(),
                  {X_IO_ * corner[i], X_IO_ * corner[j], X_IO_ * corner[k]},
                  {corner[i] / pixel_, corner[j] / pixel_, corner[k] / pixel_});
  }
}

void Painter::FillBodyDeformed(const Pose& pose) {
  const PatchSolution& c = *pose.contact;
  const std::size_t count = c.mesh.nodes.size();
  std::vector<Point> at(count), from(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto u = c.displacement.row(static_cast<Eigen::Index>(i));
    const Point rest = body_.larger_side() * c.mesh.nodes[i];
    from[i] = rest / pixel_;
    at[i] = X_IO_ * (rest + pose.displacement_O.x() * u.head<2>().transpose() +
                     pose.displacement_O.y() * u.tail<2>().transpose());
  }
  const auto fill = [&](int i, int j, int k) {
    const auto a = Index(i), b = Index(j), d = Index(k);
    speckle_.Fill(body_layer_.grey, body_layer_.window.tl(), {at[a], at[b], at[d]},
                  {from[a], from[b], from[d]});
  };
  for (const auto& v : c.mesh.triangles) {
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

// A bar from the tip backwards, longer than any way out of the picture.
void Painter::PaintTool(const Pose& pose) {
  const double length =
      pixel_ * (2.0 * (size_.width + size_.height) + (X_IO_ * pose.p_O_tip).norm());
  const Point across(-tool_O_.y(), tool_O_.x());
  // Corners of the bar grown by `rim`, tip end first, and their places on the marks.
  const auto bar = [&](double rim) {
    const Point half = (0.5 * tool_width_ + rim) * across, front = pose.p_O_tip + rim * tool_O_;
    const Point back = -(length + rim) * tool_O_;
    return std::array<Point, 4>{front - half, front + half, front + half + back,
                                front - half + back};
  };
  const auto on_marks = [&](const Point& p_O) -> Point {
    const Point from_tip = (p_O - pose.p_O_tip) / pixel_;
    return {from_tip.dot(across), -from_tip.dot(tool_O_)};
  };
  std::vector<Point> silhouette;
  for (const Point& p : bar(0)) silhouette.push_back(X_IO_ * p);
  if (tool_radius_ > 0) {  // an arc instead of the front edge
    std::vector<Point> arc;
    for (int k = 0; k <= kArcPieces; ++k) {
      const double aside = tool_width_ * (static_cast<double>(k) / kArcPieces - 0.5);
      const double left = std::max(0.0, tool_radius_ * tool_radius_ - aside * aside);
      const double behind = tool_radius_ - std::sqrt(left);
      arc.emplace_back(X_IO_ * (pose.p_O_tip + aside * across - behind * tool_O_));
    }
    silhouette.erase(silhouette.begin(), silhouette.begin() + 2);
    silhouette.insert(silhouette.begin(), arc.begin(), arc.end());
  }
  Layer& layer = tool_layer_;
  layer.window = WindowAround(silhouette, 1, size_);
  if (layer.window.empty()) return;
  Coverage coverage(layer.window);
  coverage.Add(silhouette);
  coverage.Resolve(layer.alpha);
  layer.grey.create(layer.window.size(), CV_32F);
  layer.grey.setTo(kToolDark);
  const auto c = bar(2 * pixel_);  // reaches the rim pixels whose centres lie outside
  for (const auto& [i, j, k] : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
    marks_.Fill(layer.grey, layer.window.tl(), {X_IO_ * c[i], X_IO_ * c[j], X_IO_ * c[k]},
                {on_marks(c[i]), on_marks(c[j]), on_marks(c[k])});
  }
}

// Where tool and body share a pixel they lie side by side, not one behind the other: their parts of
// the pixel add up, and the tool wins where they do not fit.
void Painter::Compose() {
  seen_(seen_dirty_).setTo(kGround);
  const int reach = exposure_.reach();
  const cv::Rect picture(cv::Point(0, 0), size_);
  const cv::Rect drawn = body_layer_.window | tool_layer_.window;
  seen_dirty_ = cv::Rect(drawn.x - reach, drawn.y - reach, drawn.width + 2 * reach,
                         drawn.height + 2 * reach) &
                picture;
  if (drawn.empty()) return;
  if (!body_layer_.window.empty()) {
    cv::Mat part = seen_(body_layer_.window);
    for (int y = 0; y < part.rows; ++y) {
      auto* out = part.ptr<float>(y);
      const auto* grey = body_layer_.grey.ptr<float>(y);
      const auto* alpha = body_layer_.alpha.ptr<float>(y);
      for (int x = 0; x < part.cols; ++x) out[x] += alpha[x] * (grey[x] - kGround);
    }
  }
  const cv::Rect both = body_layer_.window & tool_layer_.window;
  cv::Mat part = seen_(tool_layer_.window);
  for (int y = 0; y < part.rows; ++y) {
    auto* out = part.ptr<float>(y);
    const auto* grey = tool_layer_.grey.ptr<float>(y);
    const auto* alpha = tool_layer_.alpha.ptr<float>(y);
    for (int x = 0; x < part.cols; ++x) {
      if (alpha[x] == 0) continue;
      const cv::Point at(x + tool_layer_.window.x, y + tool_layer_.window.y);
      float body = 0, body_grey = 0;
      if (both.contains(at)) {
        const cv::Point in_body = at - body_layer_.window.tl();
        body = std::min(body_layer_.alpha.at<float>(in_body), 1 - alpha[x]);
        body_grey = body_layer_.grey.at<float>(in_body);
      }
      out[x] = alpha[x] * grey[x] + body * body_grey + (1 - alpha[x] - body) * kGround;
    }
  }
  cv::Mat window = seen_(seen_dirty_);
  exposure_.Blur(window);
}

cv::Mat Painter::Paint(const Pose& pose) {
  PaintBody(pose);
  PaintTool(pose);
  Compose();
  exposure_.Advance();
  cv::Mat seen = seen_;
  if (microscope_) {
    seen = seen_.clone();
    microscope_->Show(&seen);
  }
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

// Two walls, from the ends of the held arc outwards beyond the picture.
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
    Coverage coverage(window);
    coverage.Add(wall);
    cv::Mat alpha;
    coverage.Resolve(alpha);
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
  const double phase = 2 * std::numbers::pi * static_cast<double>(pictures_++) / kFocusPeriod;
  const double sigma = defocus_ * 0.5 * (1 - std::cos(phase));
  if (sigma > kLeastDefocus) cv::GaussianBlur(*seen, *seen, {}, sigma);
}

}  // namespace palpate::site
