// An incremental constrained Delaunay triangulation (Bowyer 1981, Watson 1981), the basis of the
// simulator's graded meshes. Coordinates of order one. Not thread-safe.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace palpate::site {

// A straight piece of the boundary between two points. `tag` is the caller's; halves inherit it.
struct Segment {
  int a = 0, b = 0;
  int tag = 0;
};

class Delaunay {
 public:
  static constexpr int kNone = -1;

  // Edge i lies opposite vertex i. `neighbour`: triangle behind edge i; `segment`: boundary piece
  // on edge i; kNone: neither.
  struct Triangle {
    std::array<int, 3> vertex{};  // counter-clockwise
    std::array<int, 3> neighbour{};
    std::array<int, 3> segment{kNone, kNone, kNone};
    bool inside = true;
    bool alive = true;
    unsigned generation = 0;  // rises whenever the slot is reused
  };

  // Triangulates points and boundary segments. Segments form closed loops; what an odd number of
  // loops surrounds is inside. A segment that is no Delaunay edge is halved until its pieces are.
  // Throws std::runtime_error: coinciding points, crossing segments.
  Delaunay(const std::vector<Eigen::Vector2d>& points, const std::vector<Segment>& segments);

  // Locates `p`, walking from triangle `from`. Returns false if a segment blocks the way (then
  // `blocking_segment()`), else prepares the cavity of `p`.
  bool Prepare(const Eigen::Vector2d& p, int from);
  // After Prepare: segments on the rim of the cavity whose diametral circle contains the point.
  [[nodiscard]] const std::vector<int>& encroached() const { return encroached_; }
  [[nodiscard]] int blocking_segment() const { return blocking_segment_; }
  // Puts the prepared point in; the new triangles are `created()`.
  void Commit();
  // Puts a point on the middle of segment `s`.
  void SplitSegment(int s);

  [[nodiscard]] const std::vector<int>& created() const { return created_; }
  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
  [[nodiscard]] const std::vector<Eigen::Vector2d>& points() const { return points_; }
  [[nodiscard]] const std::vector<Segment>& segments() const { return segments_; }
  // The first points are the corners of the surrounding box, no part of any body.
  static constexpr int kBoxPoints = 4;

 private:
  struct RimEdge {
    int a, b;        // counter-clockwise as seen from the cavity
    int outer;       // triangle behind
    int outer_edge;  // that triangle's index of this edge
    int segment;
    bool inside;
  };

  void MakeBox();
  void InsertFree(const Eigen::Vector2d& p);
  void RecoverSegments();
  void MarkInside();
  [[nodiscard]] int EdgeTriangle(int a, int b, int* edge) const;
  int Walk(const Eigen::Vector2d& p, int from);
  void GrowCavity(const Eigen::Vector2d& p, std::vector<int> seeds, int passable_segment);
  void AddToCavity(int t);
  void CollectRim();
  [[nodiscard]] int BadRimEdge(const Eigen::Vector2d& p) const;
  int NewTriangle();
  void Fill(int apex);
  [[nodiscard]] bool InCircle(const Triangle& t, const Eigen::Vector2d& p) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<int> point_triangle_;  // one triangle at each point
  std::vector<Triangle> triangles_;
  std::vector<int> free_;
  std::vector<Segment> segments_;
  Eigen::Vector2d prepared_{0, 0};
  int blocking_segment_ = kNone;
  std::vector<int> cavity_, created_, encroached_;
  std::vector<RimEdge> rim_;
  std::vector<unsigned> in_cavity_;  // per triangle: stamp of the last cavity it was in
  unsigned stamp_ = 0;
  std::vector<int> fan_;  // per point: new triangle whose rim edge starts there
};

// Twice the signed area of a, b, c; positive counter-clockwise.
double Orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
// Centre of the circle through three points.
Eigen::Vector2d Circumcentre(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                             const Eigen::Vector2d& c);

}  // namespace palpate::site
