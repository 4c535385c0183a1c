// SPDX-License-Identifier: Apache-2.0
#include "tests/splatting/io/test_images.h"

#include <png.h>
#include <tiffio.h>
#include <unistd.h>
#include <webp/encode.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
// jpeglib.h needs the headers above.
#include <jpeglib.h>

namespace vesta::gs {
namespace {

constexpr std::uint8_t kPalette[3][3] = {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}};

void AppendBytes(png_structp png, png_bytep bytes, std::size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), size);
}

struct TiffEntry {
  unsigned tag, type, count, value;  // or the offset of the value
};

std::string TiffNumber(unsigned value, unsigned size, bool big_endian) {
  std::string bytes;
  for (unsigned k = 0; k < size; ++k) bytes += static_cast<char>(value >> 8 * (big_endian ? size - 1 - k : k) & 0xff);
  return bytes;
}

// A directory of a TIFF. No further directory.
std::string Directory(const std::vector<TiffEntry>& entries, bool big_endian) {
  std::string bytes = TiffNumber(static_cast<unsigned>(entries.size()), 2, big_endian);
  for (const auto& [tag, type, count, value] : entries) {
    bytes += TiffNumber(tag, 2, big_endian) + TiffNumber(type, 2, big_endian);
    bytes += TiffNumber(count, 4, big_endian) + TiffNumber(value, 4, big_endian);
  }
  return bytes + TiffNumber(0, 4, big_endian);
}

// `tiff`: after its first 8 bytes, which say that its first directory is next.
std::string WithExif(const std::string& jpeg, const std::string& tiff, bool big_endian) {
  const std::string begin = (big_endian ? "MM" : "II") + TiffNumber(42, 2, big_endian) + TiffNumber(8, 4, big_endian);
  const std::string segment = std::string("Exif\0\0", 6) + begin + tiff;
  const std::size_t length = segment.size() + 2;
  return jpeg.substr(0, 2) + "\xff\xe1" + static_cast<char>(length >> 8) + static_cast<char>(length & 0xff) + segment +
         jpeg.substr(2);
}

}  // namespace

const std::uint8_t (*PaletteColors())[3] { return kPalette; }

std::string EncodePng(const PngSource& source) {
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &out, AppendBytes, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(source.width), static_cast<png_uint_32>(source.height),
               source.bit_depth, source.color_type, source.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (source.color_type == PNG_COLOR_TYPE_PALETTE) {
    png_color palette[3];
    for (int i = 0; i < 3; ++i) palette[i] = {kPalette[i][0], kPalette[i][1], kPalette[i][2]};
    png_byte alpha[3] = {255, 255, 128};
    png_set_PLTE(png, info, palette, 3);
    png_set_tRNS(png, info, alpha, 3, nullptr);
  }
  png_write_info(png, info);
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  std::vector<png_bytep> rows;
  rows.reserve(static_cast<std::size_t>(source.height));
  for (int y = 0; y < source.height; ++y) {
    rows.push_back(const_cast<png_bytep>(source.bytes.data()) + static_cast<std::size_t>(y) * row_bytes);
  }
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

std::string EncodeJpeg(const JpegSource& source) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &buffer, &size);
  info.image_width = static_cast<JDIMENSION>(source.width);
  info.image_height = static_cast<JDIMENSION>(source.height);
  info.input_components = source.components;
  info.in_color_space = source.components == 1 ? JCS_GRAYSCALE : source.components == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 100, TRUE);
  if (source.progressive) jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  const std::size_t row_bytes = static_cast<std::size_t>(source.width) * static_cast<std::size_t>(source.components);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(source.bytes.data()) + info.next_scanline * row_bytes;
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::string out(reinterpret_cast<const char*>(buffer), size);
  std::free(buffer);
  return out;
}

std::string EncodeTiff(const TiffSource& source) {
  std::FILE* file = std::tmpfile();
  TIFF* tiff = TIFFFdOpen(dup(fileno(file)), "", "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, source.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, source.height);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, source.samples);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, source.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, source.sample_format);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, source.compression);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, source.photometric);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, source.separate_planes ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
  if (source.photometric == PHOTOMETRIC_YCBCR) TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
  if (source.extra_kind >= 0) {
    const auto kind = static_cast<std::uint16_t>(source.extra_kind);
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &kind);
  }
  if (source.tile > 0) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, source.tile);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, source.tile);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
  }
  const std::size_t sample = static_cast<std::size_t>(source.bits) / 8,
                    pixel = static_cast<std::size_t>(source.samples) * sample;
  const int planes = source.separate_planes ? source.samples : 1;
  const int columns = source.tile > 0 ? source.tile : source.width, rows = source.tile > 0 ? source.tile : 1;
  for (int plane = 0; plane < planes; ++plane) {
    for (int top = 0; top < source.height; top += rows) {
      for (int left = 0; left < source.width; left += columns) {
        std::vector<std::uint8_t> block;
        for (int y = top; y < top + rows; ++y) {
          for (int x = left; x < left + columns; ++x) {
            const auto row = static_cast<std::size_t>(std::min(y, source.height - 1)),
                       column = static_cast<std::size_t>(std::min(x, source.width - 1));
            const auto from =
                source.bytes.begin() +
                static_cast<std::ptrdiff_t>((row * static_cast<std::size_t>(source.width) + column) * pixel +
                                            static_cast<std::size_t>(plane) * sample);
            block.insert(block.end(), from, from + static_cast<std::ptrdiff_t>(planes > 1 ? sample : pixel));
          }
        }
        const auto x = static_cast<std::uint32_t>(left), y = static_cast<std::uint32_t>(top);
        const auto s = static_cast<std::uint16_t>(plane);
        source.tile > 0 ? TIFFWriteTile(tiff, block.data(), x, y, 0, s) : TIFFWriteScanline(tiff, block.data(), y, s);
      }
    }
  }
  TIFFClose(tiff);
  std::string out;
  std::rewind(file);
  for (int byte = std::fgetc(file); byte != EOF; byte = std::fgetc(file)) out += static_cast<char>(byte);
  std::fclose(file);
  return out;
}

std::string EncodeWebp(int width, int height, int channels, const std::vector<std::uint8_t>& bytes) {
  std::uint8_t* encoded = nullptr;
  const auto encode = channels == 4 ? WebPEncodeLosslessRGBA : WebPEncodeLosslessRGB;
  const std::size_t size = encode(bytes.data(), width, height, width * channels, &encoded);
  std::string out(reinterpret_cast<const char*>(encoded), size);
  WebPFree(encoded);
  return out;
}

std::string ExampleJpeg(int width, int height, bool progressive) {
  JpegSource source{width, height, 3, progressive, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      source.bytes.push_back(static_cast<std::uint8_t>(255 * x / width));
      source.bytes.push_back(static_cast<std::uint8_t>(255 * y / height));
      source.bytes.push_back(static_cast<std::uint8_t>((3 * x + 5 * y) % 256));
    }
  }
  return EncodeJpeg(source);
}

std::string WithOrientation(const std::string& jpeg, int orientation, bool big_endian) {
  constexpr unsigned kShort = 3;
  // A short value is in the first two of four bytes.
  const unsigned value = static_cast<unsigned>(orientation) << (big_endian ? 16 : 0);
  return WithExif(jpeg, Directory({{274, kShort, 1, value}}, big_endian), big_endian);
}

std::string WithCamera(const std::string& jpeg, const std::string& model, unsigned focal_length, bool has_position,
                       bool big_endian) {
  constexpr unsigned kText = 2, kLong = 4, kRational = 5;
  constexpr unsigned kDetails = 50, kPosition = 68, kFocalLength = 86, kModel = 94;  // offsets
  const std::string first = Directory({{272, kText, static_cast<unsigned>(model.size()), kModel},
                                       {34665, kLong, 1, kDetails},
                                       {34853, kLong, 1, has_position ? kPosition : 0}},
                                      big_endian);
  const std::string details = Directory({{37386, kRational, 1, kFocalLength}}, big_endian);
  const std::string position = Directory({{2, kRational, 3, kFocalLength}}, big_endian);
  const std::string length = TiffNumber(focal_length, 4, big_endian) + TiffNumber(1, 4, big_endian);
  return WithExif(jpeg, first + details + position + length + model, big_endian);
}

}  // namespace vesta::gs
