#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include <jerror.h>
#include <jpeglib.h>

#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

// Replaces the error handler of libjpeg, which writes to stderr and calls exit().
struct JpegComplaint : jpeg_error_mgr {
  std::jmp_buf leave{};
  char text[JMSG_LENGTH_MAX] = "";  // empty: none
  bool ends_early = false;
  bool has_one_scan = false;
  bool has_end = true;  // whether the end marker was read; an image may be complete without it

  JpegComplaint() {
    jpeg_std_error(this);
    error_exit = &Leave;
    emit_message = &Note;
  }
  // Throws the error, if there is one.
  void Throw() const {
    if (ends_early) throw std::runtime_error("is truncated");
    if (text[0] != '\0') throw std::runtime_error("is damaged: " + std::string(text));
  }

 private:
  static JpegComplaint& Of(j_common_ptr codec) { return static_cast<JpegComplaint&>(*codec->err); }
  void Keep(j_common_ptr codec) {
    if (text[0] != '\0') return;
    format_message(codec, text);
    ends_early = !has_end || msg_code == JERR_INPUT_EOF;
  }
  [[noreturn]] static void Leave(j_common_ptr codec) {
    Of(codec).Keep(codec);
    std::longjmp(Of(codec).leave, 1);
  }
  // libjpeg continues after a warning, with invented pixels. Bytes between segments, an unknown
  // colour tag and a missing end marker are harmless, and some cameras write them. If pixels are
  // missing as well as the marker, another warning follows, unless whole scans are missing.
  static void Note(j_common_ptr codec, int level) {
    JpegComplaint& complaint = Of(codec);
    const int code = complaint.msg_code;
    if (level < 0 && code == JWRN_JPEG_EOF) complaint.has_end = false;
    const bool harmless = code == JWRN_EXTRANEOUS_DATA || code == JWRN_ADOBE_XFORM ||
                          (code == JWRN_JPEG_EOF && complaint.has_one_scan);
    if (level < 0 && !harmless) complaint.Keep(codec);
  }
};

// Runs `step` and throws errors of libjpeg. `step` must not contain objects with a destructor.
template <typename Step>
void Guard(JpegComplaint& complaint, const Step& step) {
  if (setjmp(complaint.leave) == 0) step();
  complaint.Throw();
}

struct JpegReader {
  JpegComplaint complaint;
  jpeg_decompress_struct codec{};

  JpegReader() {
    codec.err = &complaint;
    Guard(complaint, [this] { jpeg_create_decompress(&codec); });
  }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&codec); }

  void ReadHeader(Bytes bytes) {
    jpeg_mem_src(&codec, bytes.data(), bytes.size());
    jpeg_read_header(&codec, TRUE);
  }
  void ReadPixels(cv::Mat& image) {
    codec.out_color_space = image.channels() == 1 ? JCS_GRAYSCALE : JCS_EXT_BGR;
    complaint.has_one_scan = jpeg_has_multiple_scans(&codec) == FALSE;
    jpeg_start_decompress(&codec);
    while (codec.output_scanline < codec.output_height) {
      JSAMPROW row = image.ptr(static_cast<int>(codec.output_scanline));
      jpeg_read_scanlines(&codec, &row, 1);
    }
    jpeg_finish_decompress(&codec);
  }
};

class JpegImage final : public CodedImage {
 public:
  explicit JpegImage(Bytes bytes) {
    Guard(reader_.complaint, [this, bytes] { reader_.ReadHeader(bytes); });
  }

  [[nodiscard]] int colours() const { return reader_.codec.num_components; }
  [[nodiscard]] cv::Size size() const override {
    return {static_cast<int>(reader_.codec.image_width),
            static_cast<int>(reader_.codec.image_height)};
  }
  cv::Mat Decode() override {
    cv::Mat image(size(), colours() == 1 ? CV_8UC1 : CV_8UC3);
    Guard(reader_.complaint, [this, &image] { reader_.ReadPixels(image); });
    return image;
  }

 private:
  JpegReader reader_;
};

struct JpegWriter {
  JpegComplaint complaint;
  jpeg_compress_struct codec{};
  unsigned char* bytes = nullptr;  // libjpeg's, from malloc
  unsigned long count = 0;

  JpegWriter() {
    codec.err = &complaint;
    Guard(complaint, [this] { jpeg_create_compress(&codec); });
  }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  ~JpegWriter() {
    jpeg_destroy_compress(&codec);
    std::free(bytes);
  }

  void Write(const cv::Mat& image, int quality) {
    jpeg_mem_dest(&codec, &bytes, &count);
    codec.image_width = static_cast<JDIMENSION>(image.cols);
    codec.image_height = static_cast<JDIMENSION>(image.rows);
    codec.input_components = image.channels();
    codec.in_color_space = image.channels() == 1 ? JCS_GRAYSCALE : JCS_EXT_BGR;
    jpeg_set_defaults(&codec);
    jpeg_set_quality(&codec, quality, TRUE);
    jpeg_start_compress(&codec, TRUE);
    for (int y = 0; y < image.rows; ++y) {
      auto* row = const_cast<JSAMPROW>(image.ptr(y));  // libjpeg's interface; it only reads
      jpeg_write_scanlines(&codec, &row, 1);
    }
    jpeg_finish_compress(&codec);
  }
};

}  // namespace

std::unique_ptr<CodedImage> OpenJpeg(Bytes bytes) {
  if (bytes.size() < 3 || bytes[0] != 0xff || bytes[1] != 0xd8 || bytes[2] != 0xff) return nullptr;
  auto image = std::make_unique<JpegImage>(bytes);
  if (image->colours() != 1 && image->colours() != 3) return nullptr;
  return image;
}

void RequireEncodable(const cv::Mat& image, const char* format) {
  const bool known = !image.empty() && (image.channels() == 1 || image.channels() == 3) &&
                     (image.depth() == CV_8U || image.depth() == CV_16U);
  if (known) return;
  throw std::invalid_argument("image of " + std::to_string(image.cols) + " x " +
                              std::to_string(image.rows) + " px, " +
                              std::to_string(image.channels()) + " channels: for " + format +
                              ", expected 1 or 3 channels of 8 or 16 bit");
}

std::string EncodeJpeg(const cv::Mat& image, int quality) {
  RequireEncodable(image, "JPEG");
  Require(quality >= 1 && quality <= 100, "quality", quality, "1 to 100");
  cv::Mat bytes_per_channel = image;
  if (image.depth() == CV_16U) image.convertTo(bytes_per_channel, CV_8U, 1.0 / 257);
  JpegWriter writer;
  Guard(writer.complaint, [&] { writer.Write(bytes_per_channel, quality); });
  return {writer.bytes, writer.bytes + writer.count};
}

}  // namespace palpate
