// GDAL's C interface, loaded when a raster, a layer of polygons or a coordinate reference system asks for it: the
// hundred libraries behind GDAL would cost every start of the program some 50 ms. Only the files gdal*.cpp see this
// header, which is not installed; where isopach is built without GDAL, without_gdal.cpp stands in for them.
#pragma once
#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_http.h>
#include <cpl_vsi.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <gdal_utils.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <proj.h>

#include <memory>
#include <string>
#include <type_traits>

#include "isopach/io/crs.hpp"

namespace isopach {

// What of GDAL is used. All of it is in GDAL 3.6.
#define ISOPACH_GDAL_FUNCTIONS(X)   \
  X(CPLCalloc)                      \
  X(CPLGetErrorHandlerUserData)     \
  X(CPLHTTPPopFetchCallback)        \
  X(CPLHTTPPushFetchCallback)       \
  X(CPLPopErrorHandler)             \
  X(CPLPushErrorHandlerEx)          \
  X(CPLSetThreadLocalConfigOption)  \
  X(CPLStrdup)                      \
  X(GDALAllRegister)                \
  X(GDALClose)                      \
  X(GDALCreate)                     \
  X(GDALCreateCopy)                 \
  X(GDALDataTypeIsComplex)          \
  X(GDALDatasetGetLayer)            \
  X(GDALDatasetGetLayerCount)       \
  X(GDALGetBlockSize)               \
  X(GDALGetDatasetDriver)           \
  X(GDALGetDriverByName)            \
  X(GDALGetDriverShortName)         \
  X(GDALGetGeoTransform)            \
  X(GDALGetMaskBand)                \
  X(GDALGetMaskFlags)               \
  X(GDALGetRasterBand)              \
  X(GDALGetRasterCount)             \
  X(GDALGetRasterDataType)          \
  X(GDALGetRasterOffset)            \
  X(GDALGetRasterScale)             \
  X(GDALGetRasterUnitType)          \
  X(GDALGetRasterXSize)             \
  X(GDALGetRasterYSize)             \
  X(GDALGetSpatialRef)              \
  X(GDALOpenEx)                     \
  X(GDALRasterIO)                   \
  X(GDALRegister_GTiff)             \
  X(GDALSetDescription)             \
  X(GDALSetGeoTransform)            \
  X(GDALSetProjection)              \
  X(GDALSetRasterNoDataValue)       \
  X(GDALSetRasterUnitType)          \
  X(GDALVectorTranslate)            \
  X(GDALVectorTranslateOptionsFree) \
  X(GDALVectorTranslateOptionsNew)  \
  X(OGR_F_Destroy)                  \
  X(OGR_F_GetFieldAsString)         \
  X(OGR_F_GetFieldCount)            \
  X(OGR_F_GetFieldDefnRef)          \
  X(OGR_F_GetGeometryRef)           \
  X(OGR_F_IsFieldSetAndNotNull)     \
  X(OGR_Fld_GetNameRef)             \
  X(OGR_GT_Flatten)                 \
  X(OGR_G_AddGeometryDirectly)      \
  X(OGR_G_AddPoint_2D)              \
  X(OGR_G_CloseRings)               \
  X(OGR_G_CreateGeometry)           \
  X(OGR_G_DestroyGeometry)          \
  X(OGR_G_GetGeometryCount)         \
  X(OGR_G_GetGeometryRef)           \
  X(OGR_G_GetGeometryType)          \
  X(OGR_G_GetLinearGeometry)        \
  X(OGR_G_GetPointCount)            \
  X(OGR_G_GetX)                     \
  X(OGR_G_GetY)                     \
  X(OGR_G_MakeValid)                \
  X(OGR_G_SymDifference)            \
  X(OGR_L_GetNextFeature)           \
  X(OGR_L_GetSpatialRef)            \
  X(OGR_L_ResetReading)             \
  X(OSRAutoIdentifyEPSG)            \
  X(OSRClone)                       \
  X(OSRDestroySpatialReference)     \
  X(OSRExportToPROJJSON)            \
  X(OSRExportToWktEx)               \
  X(OSRFindMatches)                 \
  X(OSRFreeSRSArray)                \
  X(OSRGetAngularUnits)             \
  X(OSRGetAuthorityCode)            \
  X(OSRGetAuthorityName)            \
  X(OSRGetAxesCount)                \
  X(OSRGetLinearUnits)              \
  X(OSRGetName)                     \
  X(OSRGetTargetLinearUnits)        \
  X(OSRImportFromESRI)              \
  X(OSRImportFromWkt)               \
  X(OSRIsCompound)                  \
  X(OSRIsGeocentric)                \
  X(OSRIsGeographic)                \
  X(OSRIsLocal)                     \
  X(OSRIsProjected)                 \
  X(OSRIsSameEx)                    \
  X(OSRIsVertical)                  \
  X(OSRNewSpatialReference)         \
  X(OSRSetFromUserInput)            \
  X(OSRStripVertical)               \
  X(VSIFCloseL)                     \
  X(VSIFileFromMemBuffer)           \
  X(VSIFree)                        \
  X(VSIGetMemFileBuffer)            \
  X(VSIUnlink)

/// A function each, called as in GDAL's manual: gdal().GDALOpenEx(…).
struct Gdal {
#define ISOPACH_MEMBER(function) decltype(&::function) function = nullptr;
  ISOPACH_GDAL_FUNCTIONS(ISOPACH_MEMBER)
#undef ISOPACH_MEMBER
  /// Of the PROJ that GDAL itself uses; nullptr where that is hidden inside GDAL.
  decltype(&::proj_log_level) proj_log_level = nullptr;
};

/// Loads GDAL from the shared library of this name, which stays loaded. Throws InputError if it is not there or is not
/// GDAL: "`what` needs GDAL, …" with the system's reason and what to install. Test: tests/io/gdal_test.cpp.
[[nodiscard]] Gdal load_gdal(const std::string& library, const std::string& what);

/// The GDAL that isopach was built with, loaded by the first call. From any thread. Throws as load_gdal, and tries
/// again when it is called again. `what`: file and purpose, for the message.
const Gdal& need_gdal(const std::string& what);

/// The same where GDAL is loaded already.
[[nodiscard]] inline const Gdal& gdal() { return need_gdal("this"); }

template <auto destroy>
struct GdalDelete {
  template <class T>
  void operator()(T* handle) const {
    (gdal().*destroy)(handle);
  }
};
template <class Handle, auto destroy>
using GdalOwned = std::unique_ptr<std::remove_pointer_t<Handle>, GdalDelete<destroy>>;

using GdalDataset = GdalOwned<GDALDatasetH, &Gdal::GDALClose>;
using GdalFeature = GdalOwned<OGRFeatureH, &Gdal::OGR_F_Destroy>;
using GdalGeometry = GdalOwned<OGRGeometryH, &Gdal::OGR_G_DestroyGeometry>;
using GdalReference = GdalOwned<OGRSpatialReferenceH, &Gdal::OSRDestroySpatialReference>;
using GdalText = GdalOwned<char*, &Gdal::VSIFree>;

/// While it lives, GDAL prints nothing in this thread; the first failure it would have printed is kept, as one line.
class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;
  /// The first message of a failure; empty: none. Throws std::bad_alloc where GDAL said that it got no memory.
  [[nodiscard]] const std::string& failure() const;
  void keep(int severity, int number, const char* message);

 private:
  bool no_memory_ = false;
  std::string failure_;
};

/// While it lives, GDAL asks nothing of the network in this thread: a CRS may be an address, which GDAL would follow.
class NoNetwork {
 public:
  NoNetwork();
  ~NoNetwork();
  NoNetwork(const NoNetwork&) = delete;
  NoNetwork& operator=(const NoNetwork&) = delete;
};

/// While it lives, GDAL reports in this thread the vertical part of a GeoTIFF's CRS also where GeoTIFF 1.0 is in use.
class ReportVerticalCrs {
 public:
  ReportVerticalCrs();
  ~ReportVerticalCrs();
  ReportVerticalCrs(const ReportVerticalCrs&) = delete;
  ReportVerticalCrs& operator=(const ReportVerticalCrs&) = delete;
};

/// Name and units of a system that GDAL holds; nullptr or an empty one gives an empty name.
[[nodiscard]] Crs describe_crs(OGRSpatialReferenceH reference);

}  // namespace isopach
