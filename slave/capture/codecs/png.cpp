#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include <png.h>

#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

constexpr std::size_t kSignature = 8;  // bytes that begin every PNG

// Replaces the error handler of libpng, which writes to stderr and calls abort().
struct PngComplaint {
  char text[128] = "out of memory";
  bool ends_early = false;

  [[noreturn]] void Throw() const {
    throw std::runtime_error(ends_early ? "is truncated" : "is damaged: " + std::string(text));
  }
  [[noreturn]] static void Leave(png_structp png, png_const_charp why) {
    auto* complaint = static_cast<PngComplaint*>(png_get_error_ptr(png));
    std::strncpy(complaint->text, why, sizeof complaint->text - 1);
    png_longjmp(png, 1);
  }
  static void Ignore(png_structp, png_const_charp) {}  // no pixel depends on a warning
};

// Runs `step` and throws errors of libpng. `step` must not contain objects with a destructor.
template <typename Step>
void Guard(png_structp png, const PngComplaint& complaint, const Step& step) {
  if (setjmp(png_jmpbuf(png)) != 0) complaint.Throw();
  step();
}

struct PngReader {
  PngComplaint complaint;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &complaint, &PngComplaint::Leave,
                                           &PngComplaint::Ignore);
  png_infop info = png_create_info_struct(png);
  Bytes rest;

  explicit PngReader(Bytes bytes) : rest(bytes) {
    if (info == nullptr) complaint.Throw();
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }

  static void Take(png_structp png, png_bytep out, std::size_t count) {
    auto* self = static_cast<PngReader*>(png_get_io_ptr(png));
    self->complaint.ends_early = count > self->rest.size();
    if (self->complaint.ends_early) png_error(png, "");
    std::copy_n(self->rest.begin(), count, out);
    self->rest = self->rest.subspan(count);
  }
  void ReadHeader() {
    png_set_read_fn(png, this, &Take);
    // Reads only chunks for pixels, because others may unpack to any size.
    png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png, info);
    const int colour = png_get_color_type(png, info), depth = png_get_bit_depth(png, info);
    if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
    if (colour == PNG_COLOR_TYPE_GRAY && depth < 8) png_set_expand_gray_1_2_4_to_8(png);
    if (colour == PNG_COLOR_TYPE_GRAY_ALPHA) png_set_gray_to_rgb(png);
    png_set_strip_alpha(png);
    png_set_bgr(png);
    if (std::endian::native == std::endian::little) png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
  }
  void ReadPixels(png_bytepp rows) {
    png_read_image(png, rows);
    png_read_end(png, nullptr);
  }
};

class PngImage final : public CodedImage {
 public:
  explicit PngImage(Bytes bytes) : reader_(bytes) {
    Guard(reader_.png, reader_.complaint, [this] { reader_.ReadHeader(); });
  }

  [[nodiscard]] cv::Size size() const override {
    return {static_cast<int>(png_get_image_width(reader_.png, reader_.info)),
            static_cast<int>(png_get_image_height(reader_.png, reader_.info))};
  }
  cv::Mat Decode() override {
    const int depth = png_get_bit_depth(reader_.png, reader_.info) == 16 ? CV_16U : CV_8U;
    cv::Mat image(size(), CV_MAKETYPE(depth, png_get_channels(reader_.png, reader_.info)));
    std::vector<png_bytep> rows(static_cast<std::size_t>(image.rows));
    for (int y = 0; y < image.rows; ++y) rows[static_cast<std::size_t>(y)] = image.ptr(y);
    Guard(reader_.png, reader_.complaint, [&] { reader_.ReadPixels(rows.data()); });
    return image;
  }

 private:
  PngReader reader_;
};

struct PngWriter {
  PngComplaint complaint;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &complaint, &PngComplaint::Leave,
                                            &PngComplaint::Ignore);
  png_infop info = png_create_info_struct(png);
  std::string out;

  PngWriter() {
    if (info == nullptr) complaint.Throw();
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }

  static void Put(png_structp png, png_bytep bytes, std::size_t count) {
    static_cast<PngWriter*>(png_get_io_ptr(png))
        ->out.append(reinterpret_cast<const char*>(bytes), count);
  }
  static void Flush(png_structp) {}

  void Write(const cv::Mat& image) {
    png_set_write_fn(png, this, &Put, &Flush);
    png_set_compression_level(png, 1);  // fast, because recordings need it at the image rate
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.cols),
                 static_cast<png_uint_32>(image.rows), image.depth() == CV_16U ? 16 : 8,
                 image.channels() == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_set_bgr(png);
    if (std::endian::native == std::endian::little) png_set_swap(png);
    for (int y = 0; y < image.rows; ++y) png_write_row(png, image.ptr(y));
    png_write_end(png, info);
  }
};

}  // namespace

std::unique_ptr<CodedImage> OpenPng(Bytes bytes) {
  if (bytes.size() < kSignature || png_sig_cmp(bytes.data(), 0, kSignature) != 0) return nullptr;
  return std::make_unique<PngImage>(bytes);
}

std::string EncodePng(const cv::Mat& image) {
  RequireEncodable(image, "PNG");
  PngWriter writer;
  Guard(writer.png, writer.complaint, [&] { writer.Write(image); });
  return std::move(writer.out);
}

}  // namespace palpate
