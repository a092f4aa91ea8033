#include "slave/study/clouds/pcd_file.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/text/text.h"
#include "slave/study/clouds/pcd_header.h"

namespace palpate::study {
namespace {

static_assert(std::endian::native == std::endian::little, "PCD's binary numbers are little-endian");

template <typename T>
T Load(std::string_view bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

double LoadNumber(const PcdField& field, std::string_view bytes, std::size_t at) {
  if (field.type == 'F') return field.size == 8 ? Load<double>(bytes, at) : Load<float>(bytes, at);
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1:
      return is_signed ? Load<std::int8_t>(bytes, at) : Load<std::uint8_t>(bytes, at);
    case 2:
      return is_signed ? Load<std::int16_t>(bytes, at) : Load<std::uint16_t>(bytes, at);
    case 4:
      return is_signed ? Load<std::int32_t>(bytes, at) : Load<std::uint32_t>(bytes, at);
    default:
      return static_cast<double>(Load<std::int64_t>(bytes, at));
  }
}

// What is read of a point, wherever it stands.
struct Columns {
  const PcdField *x, *y, *z, *colour, *label;
};

Columns ColumnsOf(const std::filesystem::path& file, const PcdHeader& header) {
  Columns columns{header.Find("x"), header.Find("y"), header.Find("z"), header.Find("rgb"),
                  header.Find("label")};
  if (!columns.colour) columns.colour = header.Find("rgba");
  for (const PcdField* field : {columns.x, columns.y, columns.z}) {
    if (!field || field->type != 'F') {
      throw std::invalid_argument(
          file.string() + ": FIELDS: accepted is x, y and z of TYPE F, and optionally others");
    }
  }
  if (columns.colour && (columns.colour->size != 4 || columns.colour->type == 'I')) {
    columns.colour = nullptr;
  }
  return columns;
}

// Takes the points one by one.
class Collector {
 public:
  explicit Collector(const Columns& columns, std::size_t points)
      : has_colour_(columns.colour), has_label_(columns.label) {
    read_.cloud.points.reserve(points);
  }
  void Add(const Eigen::Vector3d& p, std::uint32_t rgb, double label) {
    if (!(p.array().abs() <= kFarthestPoint).all()) {  // so written, NaN is dropped too
      ++read_.dropped;
      if (p.allFinite()) ++read_.too_far;
      return;
    }
    read_.cloud.points.push_back(p);
    if (has_colour_) {
      read_.cloud.colours.push_back({static_cast<std::uint8_t>(rgb >> 16),
                                     static_cast<std::uint8_t>(rgb >> 8),
                                     static_cast<std::uint8_t>(rgb)});
    }
    if (has_label_) {
      const bool fits = label >= 0 && label <= std::numeric_limits<std::uint32_t>::max();
      read_.cloud.labels.push_back(fits ? static_cast<std::uint32_t>(label) : 0);
    }
  }
  PcdCloud Take() { return std::move(read_); }

 private:
  bool has_colour_, has_label_;
  PcdCloud read_;
};

// `Place` tells where a field of a point stands: binary files hold point after point, compressed
// ones field after field.
template <typename Place>
void CollectBinary(const PcdHeader& header, const Columns& columns, std::string_view bytes,
                   const Place& place, Collector* collector) {
  for (std::size_t i = 0; i < header.points; ++i) {
    const auto number = [&](const PcdField& field) {
      return LoadNumber(field, bytes, place(field, i));
    };
    const std::uint32_t rgb =
        columns.colour ? Load<std::uint32_t>(bytes, place(*columns.colour, i)) : 0;
    collector->Add({number(*columns.x), number(*columns.y), number(*columns.z)}, rgb,
                   columns.label ? number(*columns.label) : 0);
  }
}

// Colours of TYPE F are packed into the bits of a float, and written as that number.
std::uint32_t PackedColour(const PcdField& field, double value) {
  if (field.type == 'F') return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return value >= 0 && value <= 0xFFFFFFFFU ? static_cast<std::uint32_t>(value) : 0;
}

constexpr std::string_view kBlank = " \t\r";

// What stands before the next of `ends`; it is taken off `text` together with that.
std::string_view Cut(std::string_view* text, std::string_view ends) {
  const std::string_view cut = text->substr(0, text->find_first_of(ends));
  text->remove_prefix(std::min(cut.size() + 1, text->size()));
  return cut;
}

// nullopt: no number. Too large a one is infinite.
std::optional<double> ToNumber(std::string_view word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) return std::numeric_limits<double>::infinity();
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

// Fills `row` from a line; tells what is wrong with it, or nothing. A number too few or too many
// would make columns of other columns from there on.
std::string FillRow(std::string_view line, std::vector<double>* row) {
  std::size_t count = 0;
  while (!line.empty()) {
    const std::string_view word = Cut(&line, kBlank);
    if (word.empty()) continue;
    const std::optional<double> number = ToNumber(word);
    if (!number) return std::string(word.substr(0, 20));
    if (count < row->size()) (*row)[count] = *number;
    ++count;
  }
  return count == row->size() ? "" : std::to_string(count) + " numbers";
}

void CollectText(const std::filesystem::path& file, const PcdHeader& header, const Columns& columns,
                 std::string_view text, Collector* collector) {
  std::vector<double> row(header.columns);
  int line_number = header.lines;
  for (std::size_t i = 0; i < header.points;) {
    const bool ended = text.empty();
    const std::string_view line = Cut(&text, "\n");
    ++line_number;
    if (!ended && line.find_first_not_of(kBlank) == std::string_view::npos) continue;
    const std::string wrong = ended ? "the file ends" : FillRow(line, &row);
    if (!wrong.empty()) {
      throw std::invalid_argument(file.string() + ":" + std::to_string(line_number) + ": " + wrong +
                                  ": accepted is a line of " + std::to_string(header.columns) +
                                  " numbers for each of " + std::to_string(header.points) +
                                  " points");
    }
    collector->Add({row[columns.x->column], row[columns.y->column], row[columns.z->column]},
                   columns.colour ? PackedColour(*columns.colour, row[columns.colour->column]) : 0,
                   columns.label ? row[columns.label->column] : 0);
    ++i;
  }
}

std::string Decompressed(const std::filesystem::path& file, const PcdHeader& header,
                         std::string_view data) {
  const std::size_t size = header.points * header.stride;
  if (data.size() >= 8) {
    const auto packed = Load<std::uint32_t>(data, 0);
    if (Load<std::uint32_t>(data, 4) == size && packed <= data.size() - 8) {
      if (auto bytes = DecompressLzf(data.substr(8, packed), size)) return std::move(*bytes);
    }
  }
  throw std::invalid_argument(file.string() +
                              ": the compressed points are damaged or cut off: "
                              "accepted is what makes " +
                              std::to_string(size) + " bytes");
}

std::string Slurp(const std::filesystem::path& file) {
  constexpr std::uintmax_t kLargestFile = 4ULL << 30U;  // [bytes]
  try {
    return ReadWholeFile(file, kLargestFile, "a PCD file");
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
}

template <typename T>
void Append(std::string* bytes, const T& value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::optional<std::string> DecompressLzf(std::string_view stream, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&]() -> std::optional<std::size_t> {
    if (at >= stream.size()) return std::nullopt;
    return static_cast<std::uint8_t>(stream[at++]);
  };
  while (const auto control = next()) {
    if (*control < 32) {
      const std::size_t run = *control + 1;
      if (run > stream.size() - at || run > size - out.size()) return std::nullopt;
      out.append(stream, at, run);
      at += run;
      continue;
    }
    std::size_t length = *control >> 5;
    if (length == 7) {
      const auto more = next();
      if (!more) return std::nullopt;
      length += *more;
    }
    length += 2;
    const auto low = next();
    if (!low) return std::nullopt;
    const std::size_t back = ((*control & 31) << 8) + *low + 1;
    if (back > out.size() || length > size - out.size()) return std::nullopt;
    // Byte by byte: what is repeated may reach into what it makes.
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

PcdCloud ReadPcd(const std::filesystem::path& file) {
  const std::string content = Slurp(file);
  const PcdHeader header = ReadPcdHeader(file, content);
  const Columns columns = ColumnsOf(file, header);
  const std::string_view data = std::string_view(content).substr(header.end);
  Collector collector(columns, header.points);
  switch (header.data) {
    case PcdHeader::Data::kAscii:
      CollectText(file, header, columns, data, &collector);
      break;
    case PcdHeader::Data::kBinary:
      CollectBinary(
          header, columns, data,
          [&](const PcdField& field, std::size_t i) { return i * header.stride + field.offset; },
          &collector);
      break;
    case PcdHeader::Data::kCompressed:
      CollectBinary(
          header, columns, Decompressed(file, header, data),
          [&](const PcdField& field, std::size_t i) {
            return header.points * field.offset + i * field.bytes();
          },
          &collector);
      break;
  }
  return collector.Take();
}

bool WritePcd(const std::filesystem::path& file, const PointCloud& cloud) {
  const bool colours = !cloud.colours.empty(), labels = !cloud.labels.empty();
  const std::string n = std::to_string(cloud.size());
  std::string bytes = "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z";
  for (const auto& [has, name] : {std::pair{colours, " rgb"}, {labels, " label"}}) {
    if (has) bytes += name;
  }
  const auto per_field = [&](const std::string& key, const std::string& xyz, const char* extra) {
    bytes += "\n" + key + xyz;
    for (const bool has : {colours, labels}) {
      if (has) bytes += extra;
    }
  };
  per_field("SIZE", " 4 4 4", " 4");
  per_field("TYPE", " F F F", " U");
  per_field("COUNT", " 1 1 1", " 1");
  bytes += "\nWIDTH " + n + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA binary\n";
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    for (const double x : cloud.points[i]) Append(&bytes, static_cast<float>(x));
    if (colours) {
      const auto& [r, g, b] = cloud.colours[i];
      Append(&bytes, (std::uint32_t{r} << 16) | (std::uint32_t{g} << 8) | std::uint32_t{b});
    }
    if (labels) Append(&bytes, cloud.labels[i]);
  }
  return TryWrite(file, bytes);
}

}  // namespace palpate::study
