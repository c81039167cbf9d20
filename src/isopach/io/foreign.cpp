#include "isopach/io/foreign.hpp"

#include <array>
#include <cctype>

namespace isopach {
namespace {

constexpr std::string_view meshes = "convert it to PLY, OBJ or STL, e.g. with MeshLab or Blender";
constexpr std::string_view grids = "convert it to PLY, OBJ or STL, e.g. with ParaView";
constexpr std::string_view solids = "export its surface as STL from a CAD program, e.g. FreeCAD";
constexpr std::string_view clouds = "convert it to PLY or LAS, e.g. with CloudCompare or PDAL";
constexpr std::string_view arrays = "write its points as text, x y z in each line, or as PLY";
constexpr std::string_view packed = "unpack it and name the file inside";
constexpr std::string_view rasters = "convert it to GeoTIFF, e.g. with gdal_translate";
constexpr std::string_view pictures = "name the scan it was made of";

struct Magic {
  std::string_view start;
  ForeignFormat is;
};

constexpr std::array magics{
    Magic{"# vtk DataFile", {"a VTK file", grids}},
    Magic{"glTF", {"a binary glTF file (.glb)", meshes}},
    Magic{"Kaydara FBX Binary", {"an FBX file", meshes}},
    Magic{"; FBX", {"an FBX file", meshes}},
    Magic{"#VRML", {"a VRML file", meshes}},
    Magic{"#Inventor", {"an Open Inventor file", meshes}},
    Magic{"DRACO", {"a Draco file", meshes}},
    Magic{"ASTM-E57", {"an E57 file", clouds}},
    Magic{"ISO-10303-21", {"a STEP file", solids}},
    Magic{"DBRep_DrawableShape", {"a BREP file", solids}},
    Magic{"PXR-USDC", {"a USD file", meshes}},
    Magic{"#usda", {"a USD file", meshes}},
    Magic{"BLENDER", {"a Blender file", "export PLY, OBJ or STL from Blender"}},
    Magic{"\x93NUMPY", {"a NumPy array", arrays}},
    Magic{"MATLAB", {"a MATLAB file", arrays}},
    Magic{"\x89HDF", {"an HDF5 file", arrays}},
    Magic{"CDF\x01", {"a netCDF file", rasters}},
    Magic{"CDF\x02", {"a netCDF file", rasters}},
    Magic{"PK\x03\x04", {"a ZIP archive (3MF, KMZ and NPZ are such, too)", packed}},
    Magic{"\x1f\x8b", {"a gzip archive", packed}},
    Magic{"BZh", {"a bzip2 archive", packed}},
    Magic{"7z\xBC\xAF\x27\x1C", {"a 7z archive", packed}},
    Magic{"\x89PNG", {"a PNG picture", pictures}},
    Magic{"\xFF\xD8\xFF", {"a JPEG picture", pictures}},
    Magic{"%PDF", {"a PDF file", pictures}},
};

bool starts_with(std::string_view text, std::string_view what) { return text.substr(0, what.size()) == what; }

std::string_view without_mark_and_blanks(std::string_view text) {
  if (starts_with(text, "\xEF\xBB\xBF")) text.remove_prefix(3);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  return text;
}

/// "OFF", with C, N, 4, ST or n before it, alone in its line, with BINARY, or followed by the counts.
bool is_off(std::string_view text) {
  for (const std::string_view prefix : {"ST", "C", "N", "4", "n"})
    if (starts_with(text, prefix)) text.remove_prefix(prefix.size());
  if (!starts_with(text, "OFF")) return false;
  text.remove_prefix(3);
  const std::string_view line = text.substr(0, text.find_first_of("\r\n"));
  if (line.size() == text.size()) return false;  // a word, no file
  const std::size_t word = line.find_first_not_of(" \t");
  if (word == std::string_view::npos) return true;
  return word > 0 && (starts_with(line.substr(word), "BINARY") || line[word] == '#' ||
                      line.find_first_not_of("0123456789 \t") == std::string_view::npos);
}

ForeignFormat of_xml(std::string_view text) {
  constexpr std::array roots{
      Magic{"<VTKFile", {"a VTK file", grids}},
      Magic{"<COLLADA", {"a COLLADA file", meshes}},
      Magic{"<X3D", {"an X3D file", meshes}},
      Magic{"<amf", {"an AMF file", meshes}},
      Magic{"<kml", {"a KML file", arrays}},
      Magic{"<LandXML", {"a LandXML file", arrays}},
      Magic{"<svg", {"an SVG picture", pictures}},
      Magic{"<!DOCTYPE html", {"a web page", "download the file itself"}},
      Magic{"<html", {"a web page", "download the file itself"}},
  };
  for (const Magic& m : roots)
    if (text.find(m.start) != std::string_view::npos) return m.is;
  return {};
}

}  // namespace

ForeignFormat foreign_format(std::string_view head) {
  for (const Magic& m : magics)
    if (starts_with(head, m.start)) return m.is;
  const std::string_view text = without_mark_and_blanks(head);
  if (is_off(text)) return {"an OFF file", meshes};
  if (starts_with(text, "<")) return of_xml(text);
  if (starts_with(text, "{") && text.find("\"asset\"") != std::string_view::npos) return {"a glTF file", meshes};
  if (starts_with(text, "{"))
    return {"a JSON file (a glTF or GeoJSON file is one, too)",
            "convert it to PLY, OBJ or STL, or write its points as text, x y z in each line"};
  return {};
}

}  // namespace isopach
