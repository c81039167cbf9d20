// All that a program needs of isopach, of the parts that are installed. Each of these headers may be included alone,
// which compiles sooner.
#pragma once
#include "isopach/apps/accuracy.hpp"
#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/combine.hpp"
#include "isopach/apps/roughness.hpp"
#include "isopach/apps/scanners.hpp"
#include "isopach/apps/sequence.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/compare/check.hpp"
#include "isopach/compare/compare.hpp"
#include "isopach/delaunay/triangulate.hpp"
#include "isopach/delaunay/validate.hpp"
#include "isopach/distance/distance.hpp"
#include "isopach/match/match.hpp"
#include "isopach/measure/source.hpp"
#include "isopach/measure/volume/budget.hpp"
#include "isopach/simulate/scene.hpp"
#include "isopach/version.hpp"
#if __has_include("isopach/io/read.hpp")
#include "isopach/io/expression.hpp"
#include "isopach/io/polygons.hpp"
#include "isopach/io/raster_values.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"
#endif
#if __has_include("isopach/report/report.hpp")
#include "isopach/report/accuracy.hpp"
#include "isopach/report/asymmetry.hpp"
#include "isopach/report/combine.hpp"
#include "isopach/report/distance.hpp"
#include "isopach/report/match.hpp"
#include "isopach/report/report.hpp"
#include "isopach/report/roughness.hpp"
#include "isopach/report/scanners.hpp"
#include "isopach/report/sequence.hpp"
#endif
