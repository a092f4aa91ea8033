#include "slave/study/clouds/pcd_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <spdlog/fmt/fmt.h>

#include "shared/text/file_format.h"
#include "slave/statistics/robust.h"

namespace palpate::study {
namespace {

// No depth camera measures farther [m].
constexpr float kMaxPointDistance = 500;

std::invalid_argument Refusal(const std::filesystem::path& file, const std::string& why) {
  return std::invalid_argument(file.string() + ": " + why);
}

// The points in the file are fewer than its header promises, which the library does not see.
bool IsCutOff(const std::filesystem::path& file, const pcl::PCLPointCloud2& header, int form,
              unsigned begin) {
  constexpr double kBestCompression = 264;  // LZF: three bytes make at most 264
  constexpr int kAscii = 0, kCompressed = 2;
  const auto points = static_cast<double>(header.width) * header.height;
  if (form != kAscii) {
    const double bytes = static_cast<double>(std::filesystem::file_size(file)) - begin;
    return points * header.point_step > (form == kCompressed ? kBestCompression : 1) * bytes;
  }
  std::ifstream stream(file);
  stream.seekg(begin);
  double lines = 0;
  for (std::string line; std::getline(stream, line);) {
    lines += line.find_first_not_of(" \t\r") == std::string::npos ? 0 : 1;
  }
  return lines < points;
}

// Names a file without PCD's header: a file of another program, or rows of numbers.
std::string WhatIs(const std::filesystem::path& file) {
  if (const std::string foreign = ForeignFile(file); !foreign.empty()) return "is " + foreign;
  std::string first;
  std::ifstream(file) >> first;
  if (first == "ply") return "is a PLY cloud: pcl_ply2pcd converts it";
  const auto number = first.find_first_not_of("0123456789+-.eE,;");
  const bool is_text = !first.empty() && number == std::string::npos;
  return is_text
             ? "is text x y z without PCD's header: CloudCompare saves it as PCD, or write the "
               "header above the rows (VERSION 0.7, FIELDS x y z, SIZE 4 4 4, TYPE F F F, COUNT "
               "1 1 1, WIDTH, HEIGHT 1, POINTS, DATA ascii)"
             : "no PCD header";
}

pcl::PCLPointCloud2 ReadPoints(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw Refusal(file, "there is no such file");
  pcl::PCDReader reader;
  pcl::PCLPointCloud2 points;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0, form = 0;
  unsigned begin = 0;
  if (reader.readHeader(file.string(), points, origin, orientation, version, form, begin) < 0 ||
      begin == 0 || points.fields.empty()) {
    throw Refusal(file, WhatIs(file) + ": expected a PCD file of the Point Cloud Library");
  }
  const std::uint64_t promised = std::uint64_t{points.width} * points.height;
  if (IsCutOff(file, points, form, begin) || reader.read(file.string(), points) < 0) {
    throw Refusal(file, "damaged or cut off: expected " + std::to_string(promised) +
                            " points, as in its header");
  }
  return points;
}

void RequireTypes(const std::filesystem::path& file, pcl::PCLPointCloud2* points) {
  std::size_t coordinates = 0;
  for (pcl::PCLPointField& field : points->fields) {
    const bool is_packed = field.name == "rgb" && field.datatype == pcl::PCLPointField::UINT32;
    if (is_packed) field.name = "rgba";
    const bool is_coordinate = field.name == "x" || field.name == "y" || field.name == "z";
    coordinates += is_coordinate ? 1 : 0;
    if (is_coordinate && field.datatype != pcl::PCLPointField::FLOAT32) {
      throw Refusal(file, "field " + field.name + ": expected TYPE F and SIZE 4");
    }
    if (field.name == "label" && field.datatype != pcl::PCLPointField::UINT32) {
      throw Refusal(file, "field label: expected TYPE U and SIZE 4");
    }
  }
  if (coordinates != 3) throw Refusal(file, "expected fields x, y and z of TYPE F and SIZE 4");
}

// Cameras that write millimetres are common.
void RequireMetres(const std::filesystem::path& file, std::vector<float> distances) {
  constexpr float kPlausible = 20;  // [m]
  if (distances.empty()) throw Refusal(file, "no finite point: expected one or more");
  const float median = MedianOf(distances);
  if (median <= kPlausible) return;
  throw Refusal(file, fmt::format("the median distance of its points is {:.3g} m: the units look "
                                  "wrong: expected a cloud in metres, within {:g} m",
                                  median, kPlausible));
}

}  // namespace

PcdCloud ReadPcd(const std::filesystem::path& file) {
  // Because its messages do not name the file.
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  PointCloud all;
  try {
    pcl::PCLPointCloud2 points = ReadPoints(file);
    RequireTypes(file, &points);
    pcl::fromPCLPointCloud2(points, all);
  } catch (const std::invalid_argument&) {
    throw;
  } catch (const std::exception& failure) {  // the library's, and std::bad_alloc
    throw Refusal(file, std::string("damaged: ") + failure.what());
  }
  PcdCloud read{std::make_shared<PointCloud>()};
  std::vector<float> distances;
  for (const auto& point : all) {
    const float distance = point.getVector3fMap().norm();
    if (std::isfinite(distance)) distances.push_back(distance);
    if (distance <= kMaxPointDistance) read.cloud->push_back(point);
  }
  RequireMetres(file, std::move(distances));
  read.dropped = all.size() - read.cloud->size();
  return read;
}

bool WritePcd(const std::filesystem::path& file, const PointCloud& cloud) {
  try {
    return pcl::PCDWriter().writeBinary(file.string(), cloud) == 0;
  } catch (const pcl::PCLException&) {
    return false;
  }
}

}  // namespace palpate::study
