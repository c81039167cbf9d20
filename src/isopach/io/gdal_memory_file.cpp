#include "isopach/io/gdal_memory_file.hpp"

#include <fmt/format.h>

#include <new>

#include "isopach/io/gdal.hpp"

namespace isopach {

// The address of the bytes makes the name unique among threads. GDAL only reads what it is asked to open read-only.
GdalMemoryFile::GdalMemoryFile(std::span<const char> bytes)
    : path_(fmt::format("/vsimem/isopach-{}", fmt::ptr(bytes.data()))) {
  auto* const data = reinterpret_cast<GByte*>(const_cast<char*>(bytes.data()));
  VSILFILE* const file = gdal().VSIFileFromMemBuffer(path_.c_str(), data, bytes.size(), FALSE);
  if (file == nullptr) throw std::bad_alloc();
  gdal().VSIFCloseL(file);
}

GdalMemoryFile::~GdalMemoryFile() { gdal().VSIUnlink(path_.c_str()); }

}  // namespace isopach
