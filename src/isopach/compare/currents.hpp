// The stage of compare that measures both scans as currents.
#pragma once
#include "isopach/compare/stages.hpp"

namespace isopach::stages {

/// Refuses options that speak of currents where none are measured, or that do not go with them.
void check_currents(const CompareOptions& options);

/// Refuses scans whose heights have another unit than x and y: currents are in space. After check_units.
void check_currents_units(const CloudView& a, const CloudView& b, const Comparison& c);

/// c.currents, if options.measure asks for them; sets the sigma that was used in c.currents alone. Over the overlap the
/// kept triangles of each scan are cut to the footprint of the other. Throws OverlapError where none of a scan lies
/// over the other. Test: Currents.TrianglesAtTheRimOfTheOtherScanAreCut.
void measure_currents(const Pair& pair, const Domain& domain, Comparison& c, const Context& context);

}  // namespace isopach::stages
