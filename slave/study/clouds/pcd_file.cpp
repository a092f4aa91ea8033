#include "slave/study/clouds/pcd_file.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

#include <pcl/PCLPointCloud2.h>
#include <pcl/common/io.h>
#include <pcl/console/print.h>
#include <pcl/conversions.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace palpate::study {
namespace {

// The library's complaints name no file; ours do.
void KeepLibraryQuiet() {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
}

std::invalid_argument Refusal(const std::filesystem::path& file, const std::string& why) {
  return std::invalid_argument(file.string() + ": " + why);
}

template <typename T>
T Load(const pcl::PCLPointCloud2& blob, std::size_t at) {
  T value;
  std::memcpy(&value, blob.data.data() + at, sizeof value);
  return value;
}

const pcl::PCLPointField* Find(const pcl::PCLPointCloud2& blob, const std::string& name) {
  const int index = pcl::getFieldIndex(blob, name);
  return index < 0 ? nullptr : &blob.fields[static_cast<std::size_t>(index)];
}

// A coordinate of the file.
const pcl::PCLPointField& Coordinate(const std::filesystem::path& file,
                                     const pcl::PCLPointCloud2& blob, const std::string& name) {
  const pcl::PCLPointField* field = Find(blob, name);
  const bool is_floating = field != nullptr && (field->datatype == pcl::PCLPointField::FLOAT32 ||
                                                field->datatype == pcl::PCLPointField::FLOAT64);
  if (!is_floating) throw Refusal(file, "expected fields x, y and z of TYPE F");
  return *field;
}

// Whether the file has room for the points that its header promises. The library does not look.
bool HasRoom(const std::filesystem::path& file, const pcl::PCLPointCloud2& blob, int form,
             unsigned begin) {
  constexpr double kBestCompression = 300;  // LZF: three bytes make at most 264
  constexpr int kAscii = 0, kCompressed = 2;
  const auto points = static_cast<double>(blob.width) * static_cast<double>(blob.height);
  if (form != kAscii) {
    const double bytes = static_cast<double>(std::filesystem::file_size(file)) - begin;
    return points * blob.point_step <= (form == kCompressed ? kBestCompression : 1) * bytes;
  }
  std::ifstream stream(file);
  stream.seekg(begin);
  double lines = 0;
  for (std::string line; std::getline(stream, line);) {
    lines += line.find_first_not_of(" \t\r") == std::string::npos ? 0 : 1;
  }
  return lines >= points;
}

pcl::PCLPointCloud2 ReadBlob(const std::filesystem::path& file) {
  KeepLibraryQuiet();
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) throw Refusal(file, "there is no such file");
  pcl::PCDReader reader;
  pcl::PCLPointCloud2 blob;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0, form = 0;
  unsigned begin = 0;
  std::string library;  // its complaint
  try {
    if (reader.readHeader(file.string(), blob, origin, orientation, version, form, begin) < 0 ||
        begin == 0 || blob.fields.empty()) {
      throw Refusal(file, "no PCD header: expected a file of the Point Cloud Library");
    }
    if (!HasRoom(file, blob, form, begin)) {
      throw Refusal(file, "cut off: expected " +
                              std::to_string(std::uint64_t{blob.width} * blob.height) +
                              " points, as in its header");
    }
    if (reader.read(file.string(), blob, origin, orientation, version) == 0) return blob;
  } catch (const std::invalid_argument&) {
    throw;
  } catch (const std::exception& failure) {
    library = std::string(": ") + failure.what();
  }
  throw Refusal(file, "damaged or cut off" + library);
}

double NumberAt(const pcl::PCLPointCloud2& blob, const pcl::PCLPointField& field, std::size_t at) {
  switch (field.datatype) {
    case pcl::PCLPointField::INT8:
      return Load<std::int8_t>(blob, at);
    case pcl::PCLPointField::UINT8:
      return Load<std::uint8_t>(blob, at);
    case pcl::PCLPointField::INT16:
      return Load<std::int16_t>(blob, at);
    case pcl::PCLPointField::UINT16:
      return Load<std::uint16_t>(blob, at);
    case pcl::PCLPointField::INT32:
      return Load<std::int32_t>(blob, at);
    case pcl::PCLPointField::UINT32:
      return Load<std::uint32_t>(blob, at);
    case pcl::PCLPointField::FLOAT64:
      return Load<double>(blob, at);
    default:
      return static_cast<double>(Load<float>(blob, at));
  }
}

// The field that packs a colour into four bytes; nullptr: none.
const pcl::PCLPointField* FindColour(const pcl::PCLPointCloud2& blob) {
  for (const char* name : {"rgb", "rgba"}) {
    const pcl::PCLPointField* field = Find(blob, name);
    const bool is_packed = field != nullptr && (field->datatype == pcl::PCLPointField::FLOAT32 ||
                                                field->datatype == pcl::PCLPointField::UINT32);
    if (is_packed) return field;
  }
  return nullptr;
}

}  // namespace

PcdCloud ReadPcd(const std::filesystem::path& file) {
  const pcl::PCLPointCloud2 blob = ReadBlob(file);
  const pcl::PCLPointField* axes[3] = {&Coordinate(file, blob, "x"), &Coordinate(file, blob, "y"),
                                       &Coordinate(file, blob, "z")};
  const pcl::PCLPointField* colour = FindColour(blob);
  const pcl::PCLPointField* label = Find(blob, "label");
  PcdCloud read;
  for (std::size_t i = 0; i < blob.data.size() / std::max(1U, blob.point_step); ++i) {
    const std::size_t point = i * blob.point_step;
    Eigen::Vector3d p;
    for (int k = 0; k < 3; ++k) p[k] = NumberAt(blob, *axes[k], point + axes[k]->offset);
    if (!(p.array().abs() <= kFarthestPoint).all()) {  // so written, NaN is dropped too
      ++read.dropped;
      if (p.allFinite()) ++read.too_far;
      continue;
    }
    read.cloud.points.push_back(p);
    if (colour != nullptr) {
      const auto rgb = Load<std::uint32_t>(blob, point + colour->offset);
      read.cloud.colours.push_back({static_cast<std::uint8_t>(rgb >> 16),
                                    static_cast<std::uint8_t>(rgb >> 8),
                                    static_cast<std::uint8_t>(rgb)});
    }
    if (label != nullptr) {
      const double value = NumberAt(blob, *label, point + label->offset);
      const bool fits = value >= 0 && value <= std::numeric_limits<std::uint32_t>::max();
      read.cloud.labels.push_back(fits ? static_cast<std::uint32_t>(value) : 0);
    }
  }
  return read;
}

bool WritePcd(const std::filesystem::path& file, const PointCloud& cloud) {
  KeepLibraryQuiet();
  pcl::PointCloud<pcl::PointXYZ> places;
  pcl::PointCloud<pcl::RGB> colours;
  pcl::PointCloud<pcl::Label> labels;
  for (const Eigen::Vector3d& p : cloud.points) {
    const Eigen::Vector3f q = p.cast<float>();
    places.push_back({q.x(), q.y(), q.z()});
  }
  for (const auto& [r, g, b] : cloud.colours) colours.push_back(pcl::RGB(r, g, b));
  for (const std::uint32_t label : cloud.labels) {
    labels.push_back({});
    labels.back().label = label;
  }
  pcl::PCLPointCloud2 blob;
  pcl::toPCLPointCloud2(places, blob);
  const auto add = [&blob](const auto& part) {
    if (part.empty()) return;
    pcl::PCLPointCloud2 fields, joined;
    pcl::toPCLPointCloud2(part, fields);
    pcl::concatenateFields(blob, fields, joined);
    blob = joined;
  };
  add(colours);
  add(labels);
  try {
    return pcl::PCDWriter().writeBinary(file.string(), blob) == 0;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace palpate::study
