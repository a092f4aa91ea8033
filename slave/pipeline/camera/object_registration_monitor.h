// Checks in every image by the object's edge whether the object is at its rest surface and indented
// as the model computes.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/mesh/outline.h"
#include "slave/vision/object_sighting.h"
#include "slave/vision/observation.h"
#include "slave/vision/rest_edge.h"

namespace palpate {

// Used by one thread.
class ObjectRegistrationMonitor {
  static constexpr int kUnknowns =
      6;  // shift x, y, rotation, growth, indentation x, y [px] [by definition]
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

 public:
  // Occlusion of the edge: a bar of `width` [px] that ends at `p_I_tip` and points along the unit
  // vector `d_I`.
  struct Bar {
    Eigen::Vector2d p_I_tip{0, 0}, d_I{0, 1};
    double width = 0;
  };

  // `rest_I`: the refined outline in `first`; X_SO: the object's registered pose. Points off the
  // outline of `mesh` are ignored.
  ObjectRegistrationMonitor(const cv::Mat& first, CurveView rest_I, const CameraView& view,
                            const Eigen::Isometry3d& X_SO, const BoundaryMesh& mesh);

  // Call this when the mesh's vertices have moved: the basis is discarded.
  void Adopt(const BoundaryMesh& mesh);
  // Position of a contact's patch at rest, its width and the length of the elements there [px].
  struct Patch {
    Eigen::Vector2d p_I{0, 0};
    double width = 0, element = 1;
  };
  // Sets the motion of the vertices per unit motion of the patch along x and y of O [-].
  void SetIndentation(const std::vector<Eigen::Vector3d>& along_x,
                      const std::vector<Eigen::Vector3d>& along_y, const Patch& patch) noexcept;
  void ForgetIndentation() noexcept { has_indentation_ = false; }

  // Result of Measure for one image.
  struct Match {
    ObjectSighting sighting;
    Vector x = Vector::Zero();
  };
  // Finds the edge in `image` from the last accepted match on. `expected_O`: displacement of the
  // patch that is to be expected [px], O. Changes no match. Real-time safe.
  [[nodiscard]] Match Measure(const cv::Mat& image, const Bar& tool,
                              const Eigen::Vector2d& expected_O) noexcept;
  // `match` is that of the last image.
  void Accept(const Match& match) noexcept;
  [[nodiscard]] const ObjectSighting& sighting() const { return match_.sighting; }
  // The edge of the first image with the observed motion and indentation [px]; empty: not observed.
  [[nodiscard]] Curve Edge() const;
  void Reset() noexcept;

 private:
  struct Anchor {                  // normal of a point on the mesh
    std::size_t from = 0, to = 0;  // vertices
    double s = 0;                  // position between them [0, 1]
    bool on_outline = true;
    double indentation_sigma = 0;  // error of the modelled motion, relative [-]
    Eigen::Matrix2d indentation_I =
        Eigen::Matrix2d::Zero();  // motion of a point in I per indentation [-]
  };
  struct Sight {  // of a point in this image
    std::size_t place = 0;
    double offset = 0;     // of the edge from the prediction, along the normal [px]
    bool along_x = false;  // direction of its normal
    double sharpness = 1, exposure = 0;
    double sigma = 0;
    Vector J;  // d(offset) / d(unknowns)
  };

  void Gather(const cv::Mat& image, const Bar& tool, const Vector& x) noexcept;
  [[nodiscard]] ImageMotion MotionOf(const Vector& x) const noexcept;
  bool Fit(Vector& x) noexcept;
  bool FitFrom(const cv::Mat& image, const Bar& tool, Vector& x) noexcept;
  void Compare(const Vector& move, double scale) noexcept;
  [[nodiscard]] double SharpnessAlong(bool along_x) noexcept;
  [[nodiscard]] double Exposure() noexcept;
  void SetSighting(const Bar& tool) noexcept;

  CameraView view_;
  Eigen::Isometry3d X_SO_;
  RestEdge edge_;
  Eigen::Vector2d centre_{0, 0};  // spread of the points [px]
  double size_ = 1;               // from there to the farthest [px]
  Eigen::Matrix2d to_image_;      // direction in O -> direction in I, same length
  std::vector<Anchor> anchors_;   // per point
  bool has_indentation_ = false;
  double sharpness_at_rest_ = 0;  // 0: not known yet

  Match match_;  // of the last image
  // State of the Measure in progress.
  Match found_;
  Vector prior_;
  Matrix covariance_;
  std::vector<Sight> sights_;
  std::vector<double> sorted_;
};

}  // namespace palpate
