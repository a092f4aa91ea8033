// The object's edge at rest, searched again in every image, point by point.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/closed_curve.h"
#include "slave/vision/edge_profile.h"
#include "slave/vision/grey.h"

namespace palpate {

// Motion of an image relative to the first: p -> centre + shift + exp(growth) R(angle) (p -
// centre).
struct ImageMotion {
  Eigen::Vector2d centre{0, 0}, shift{0, 0};  // [px]
  double angle = 0;                           // [rad], from x towards y of I
  double growth = 0;                          // logarithm of the scale [-]

  // d = exp(growth) R(angle): of directions in the first image.
  [[nodiscard]] Eigen::Matrix2d linear() const;
  [[nodiscard]] Eigen::Vector2d Apply(const Eigen::Vector2d& p) const {
    return centre + shift + linear() * (p - centre);
  }
  [[nodiscard]] Eigen::Vector2d Back(const Eigen::Vector2d& p) const {
    return centre + linear().inverse() * (p - centre - shift);
  }
};

class RestEdge {
 public:
  static constexpr int kMaxReach = 36;  // largest distance of any search [px]

  struct Place {
    Eigen::Vector2d p_I, n_I;  // in the first image [px]; unit normal, on the same side all round
    double step = 0;           // of the grey level along n_I
    double dark = 0;           // grey level on its darker side
  };

  // `rest`: points on the edge in `first` [px], in order, a few px apart (RefineContour). Points
  // without a straight edge around them are not used.
  RestEdge(const cv::Mat& first, const GreyFormat& format, CurveView rest);

  [[nodiscard]] const std::vector<Place>& places() const { return places_; }
  [[nodiscard]] bool Fits(const cv::Mat& image) const noexcept {
    return profile_.format().Fits(image);
  }

  // Distance along the unit vector `n` from `p` [px] to the edge of the point, at most `reach`: the
  // steepest step of its sign, nearer ones preferred; then its centroid, as in RefineContour.
  // nullopt: too weak, or outside the image. `image` fits. Real-time safe.
  std::optional<double> Locate(const cv::Mat& image, const Place& place, const Eigen::Vector2d& p,
                               const Eigen::Vector2d& n, int reach) noexcept;

  // Returns the step of the last edge within 3 px relative to that within 8 px; 1 is sharp.
  [[nodiscard]] double sharpness() const { return sharpness_; }

  // Returns the expected level of the brighter side of the last edge if it had grown as its darker
  // one since the first image, relative to the largest level; 0: that side is not clipped.
  [[nodiscard]] double exposure() const { return exposure_; }

  // The shift to add to `motion`, up to kMaxReach - 2 along x and y, at which most points find an
  // edge; to about a pixel. Real-time safe; a fraction of a millisecond.
  Eigen::Vector2d FindShift(const cv::Mat& image, const ImageMotion& motion) noexcept;

 private:
  static constexpr int kMargin = 8;  // beyond the reach, for the windows of step and centroid [px]

  void Expose(const Place& place, int at) noexcept;
  [[nodiscard]] double Votes(const Eigen::Vector2d& shift) const noexcept;

  EdgeProfile profile_;
  std::vector<Place> places_;
  double sharpness_ = 1, exposure_ = 0;
  std::vector<float> votes_;  // points x (2 kMaxReach + 1)
  std::vector<Eigen::Vector2d> normals_;
};

}  // namespace palpate
