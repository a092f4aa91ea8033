#include "tests/slave/capture/fake_openni.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <OniCAPI.h>
#include <OniCProperties.h>

namespace palpate {

FakeOpenNi& TheFakeOpenNi() {
  static FakeOpenNi fake;
  return fake;
}

namespace {

constexpr int kWidth = 4, kHeight = 2;  // [px]

struct Stream {
  bool is_mirrored = true;  // as a camera for games is by default
  std::vector<std::uint16_t> pixels;
  OniFrame frame{};
};

OniVideoMode Mode() {
  const FakeOpenNi& fake = TheFakeOpenNi();
  const auto is = [&](double unit) { return std::abs(fake.unit - unit) < 1e-9; };
  OniPixelFormat format = ONI_PIXEL_FORMAT_SHIFT_9_2;
  if (is(1e-3)) format = ONI_PIXEL_FORMAT_DEPTH_1_MM;
  if (is(1e-4)) format = ONI_PIXEL_FORMAT_DEPTH_100_UM;
  return {format, kWidth, kHeight, 30};
}

Stream* Of(OniStreamHandle handle) {
  return reinterpret_cast<Stream*>(handle);
}

}  // namespace
}  // namespace palpate

using palpate::TheFakeOpenNi;

extern "C" {

OniStatus oniInitialize(int /*version*/) {
  return ONI_STATUS_OK;
}

OniStatus oniGetDeviceList(OniDeviceInfo** devices, int* count) {
  *count = TheFakeOpenNi().cameras;
  *devices = new OniDeviceInfo[static_cast<std::size_t>(*count)]{};
  for (int i = 0; i < *count; ++i) {
    std::strncpy((*devices)[i].uri, std::to_string(i).c_str(), ONI_MAX_STR - 1);
  }
  return ONI_STATUS_OK;
}

OniStatus oniReleaseDeviceList(OniDeviceInfo* devices) {
  delete[] devices;
  return ONI_STATUS_OK;
}

OniStatus oniDeviceOpen(const char* /*uri*/, OniDeviceHandle* device) {
  static int one = 0;
  *device = reinterpret_cast<OniDeviceHandle>(&one);
  return ONI_STATUS_OK;
}

OniStatus oniDeviceClose(OniDeviceHandle /*device*/) {
  return ONI_STATUS_OK;
}

OniStatus oniDeviceGetInfo(OniDeviceHandle /*device*/, OniDeviceInfo* info) {
  *info = {};
  return ONI_STATUS_OK;
}

OniBool oniDeviceIsPropertySupported(OniDeviceHandle /*device*/, int /*property*/) {
  return 0;
}

OniBool oniDeviceIsCommandSupported(OniDeviceHandle /*device*/, int /*command*/) {
  return 0;
}

OniStatus oniDeviceCreateStream(OniDeviceHandle /*device*/, OniSensorType /*sensor*/,
                                OniStreamHandle* stream) {
  if (!TheFakeOpenNi().has_depth) return ONI_STATUS_NOT_SUPPORTED;
  *stream = reinterpret_cast<OniStreamHandle>(new palpate::Stream);
  return ONI_STATUS_OK;
}

void oniStreamDestroy(OniStreamHandle stream) {
  delete palpate::Of(stream);
}

OniStatus oniStreamStart(OniStreamHandle /*stream*/) {
  return ONI_STATUS_OK;
}

void oniStreamStop(OniStreamHandle /*stream*/) {}

const OniSensorInfo* oniStreamGetSensorInfo(OniStreamHandle /*stream*/) {
  static const OniSensorInfo info{ONI_SENSOR_DEPTH, 0, nullptr};
  return &info;
}

OniBool oniStreamIsPropertySupported(OniStreamHandle /*stream*/, int property) {
  return property == ONI_STREAM_PROPERTY_MIRRORING || property == ONI_STREAM_PROPERTY_VIDEO_MODE;
}

OniStatus oniStreamSetProperty(OniStreamHandle stream, int property, const void* data,
                               int /*size*/) {
  if (property != ONI_STREAM_PROPERTY_MIRRORING || !TheFakeOpenNi().can_unmirror) {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  palpate::Of(stream)->is_mirrored = *static_cast<const OniBool*>(data) != 0;
  return ONI_STATUS_OK;
}

OniStatus oniStreamGetProperty(OniStreamHandle stream, int property, void* data, int* /*size*/) {
  if (property == ONI_STREAM_PROPERTY_MIRRORING) {
    *static_cast<OniBool*>(data) = palpate::Of(stream)->is_mirrored ? 1 : 0;
  } else if (property == ONI_STREAM_PROPERTY_VIDEO_MODE) {
    *static_cast<OniVideoMode*>(data) = palpate::Mode();
  } else {
    return ONI_STATUS_NOT_SUPPORTED;
  }
  return ONI_STATUS_OK;
}

OniStatus oniWaitForAnyStream(OniStreamHandle* /*streams*/, int /*count*/, int* index,
                              int /*timeout*/) {
  *index = 0;
  return ONI_STATUS_OK;
}

OniStatus oniStreamReadFrame(OniStreamHandle handle, OniFrame** frame) {
  palpate::Stream& stream = *palpate::Of(handle);
  stream.pixels = {1, 2, 3, 4, 5, 6, 7, 8};
  for (auto row = stream.pixels.begin(); stream.is_mirrored && row != stream.pixels.end();
       row += palpate::kWidth) {
    std::reverse(row, row + palpate::kWidth);
  }
  stream.frame.data = stream.pixels.data();
  stream.frame.width = palpate::kWidth;
  stream.frame.height = palpate::kHeight;
  stream.frame.stride = 2 * palpate::kWidth;
  *frame = &stream.frame;
  return ONI_STATUS_OK;
}

void oniFrameRelease(OniFrame* /*frame*/) {}

}  // extern "C"
