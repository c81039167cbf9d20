#include "isopach/io/gdal.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstring>
#include <filesystem>
#include <new>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

// "libgdal.so.32" comes with the package libgdal32, on Debian and Ubuntu.
std::string package_of(const std::string& library) {
  const std::string file = std::filesystem::path(library).filename().string();
  const std::string stem = "libgdal.so.";
  return file.starts_with(stem) ? "libgdal" + file.substr(stem.size()) : "libgdal";
}

[[noreturn]] void fail(const std::string& what, const std::string& library, const std::string& cause) {
  throw InputError(fmt::format("{} needs GDAL, which cannot be loaded ({}): install it (package {})", what, cause,
                               package_of(library)));
}

/// The loader of the C library has no number for it: all of its messages of this kind begin so.
bool says_no_memory(const char* message) {
  for (const char* words : {"cannot create ", "cannot allocate ", "cannot extend ", "out of memory"})
    if (std::strstr(message, words) != nullptr) return true;
  return false;
}

void CPL_STDCALL keep_message(CPLErr severity, CPLErrorNum number, const char* message) {
  // Behind a fatal message GDAL prints and aborts. It is C++: an exception passes through it.
  if (severity == CE_Fatal) throw std::bad_alloc();
  static_cast<GdalMessages*>(gdal().CPLGetErrorHandlerUserData())->keep(severity, number, message);
}

CPLHTTPResult* no_answer(const char*, CSLConstList, GDALProgressFunc, void*, CPLHTTPFetchWriteFunc, void*, void*) {
  auto* const result = static_cast<CPLHTTPResult*>(gdal().CPLCalloc(1, sizeof(CPLHTTPResult)));
  result->nStatus = 1;
  result->pszErrBuf = gdal().CPLStrdup("the network is not used");
  return result;
}

}  // namespace

Gdal load_gdal(const std::string& library, const std::string& what) {
  void* const handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* const cause = dlerror();
    if (cause != nullptr && says_no_memory(cause)) throw std::bad_alloc();
    fail(what, library, cause != nullptr ? cause : library);
  }
  Gdal loaded;
  const auto find = [&]<class Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(dlsym(handle, name));
    return function != nullptr;
  };
#define ISOPACH_FIND(function) \
  if (!find(loaded.function, #function)) fail(what, library, library + " has no " #function);
  ISOPACH_GDAL_FUNCTIONS(ISOPACH_FIND)
#undef ISOPACH_FIND
  find(loaded.proj_log_level, "proj_log_level");
  return loaded;
}

const Gdal& need_gdal(const std::string& what) {
  static const Gdal loaded = load_gdal(ISOPACH_GDAL_LIBRARY, what);
  return loaded;
}

GdalMessages::GdalMessages() {
  gdal().CPLPushErrorHandlerEx(keep_message, this);
  // GDAL's reader of GeoTIFF keys asks PROJ through a context of its own, which would print of units it does not know.
  if (gdal().proj_log_level != nullptr) gdal().proj_log_level(nullptr, PJ_LOG_NONE);
}
GdalMessages::~GdalMessages() { gdal().CPLPopErrorHandler(); }

const std::string& GdalMessages::failure() const {
  if (no_memory_) throw std::bad_alloc();
  return failure_;
}

void GdalMessages::keep(int severity, int number, const char* message) {
  // The reader of GeoJSON makes a message of the exception, with the number of any other.
  if (number == CPLE_OutOfMemory || std::strstr(message, "bad_alloc") != nullptr) no_memory_ = true;
  if (severity < CE_Failure || !failure_.empty()) return;
  failure_ = std::string("GDAL: ") + message;
  for (char& c : failure_)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
}

NoNetwork::NoNetwork() { gdal().CPLHTTPPushFetchCallback(no_answer, nullptr); }
NoNetwork::~NoNetwork() { gdal().CPLHTTPPopFetchCallback(); }

ReportVerticalCrs::ReportVerticalCrs() { gdal().CPLSetThreadLocalConfigOption("GTIFF_REPORT_COMPD_CS", "YES"); }
ReportVerticalCrs::~ReportVerticalCrs() { gdal().CPLSetThreadLocalConfigOption("GTIFF_REPORT_COMPD_CS", nullptr); }

}  // namespace isopach
