// Files of formats that are not read: the message names the format by what the file holds, and what to do.
#include "isopach/io/foreign.hpp"

#include <gtest/gtest.h>

#include <string>

#include "isopach/io/read.hpp"
#include "tests/io/files.hpp"

namespace isopach {
namespace {

std::string name_of(std::string_view head) { return std::string(foreign_format(head).name); }

TEST(Foreign, IsNamedByItsContent) {
  EXPECT_EQ(name_of("# vtk DataFile Version 3.0\nfran\nASCII\nDATASET POLYDATA\n"), "a VTK file");
  EXPECT_EQ(name_of("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">"), "a VTK file");
  EXPECT_EQ(name_of("OFF\n8 6 0\n0 0 0\n"), "an OFF file");
  EXPECT_EQ(name_of("OFF 8 6 0\n0 0 0\n"), "an OFF file");
  EXPECT_EQ(name_of("\n  COFF\r\n# a cube\r\n8 6 0\r\n"), "an OFF file");
  EXPECT_EQ(name_of("OFF BINARY\n\x01\x02"), "an OFF file");
  EXPECT_EQ(name_of(std::string_view("glTF\x02\0\0\0", 8)), "a binary glTF file (.glb)");
  EXPECT_EQ(name_of("{\n \"asset\" : {\"version\": \"2.0\"}}"), "a glTF file");
  EXPECT_EQ(name_of("PK\x03\x04 3D/3dmodel.model"), "a ZIP archive (3MF, KMZ and NPZ are such, too)");
  EXPECT_EQ(name_of("ISO-10303-21;\nHEADER;"), "a STEP file");
}

TEST(Foreign, LeavesWhatIsReadAlone) {
  for (const char* text : {"", "1 2 3\n", "# x y z\n1 2 3\n", "x,y,z\n1,2,3\n", "solid part\n facet normal 0 0 1\n",
                           "ply\nformat ascii 1.0\n", "# .PCD v0.7\n", "ncols 2\nnrows 2\n", "v 0 0 0\nf 1 2 3\n",
                           "offset x y z\n", "OFFSET;x;y;z\n", "OFF"})
    EXPECT_EQ(name_of(text), "") << text;
}

TEST(Foreign, TheReaderSaysWhatAFileIsWhateverItsName) {
  const test::TempFolder folder;
  const auto refused = [&](const std::string& name, const std::string& content, const std::string& says) {
    test::write_file(folder / name, content);
    test::expect_input_error([&] { (void)read_cloud(folder / name, {}, Context{}); }, folder / name, says);
  };
  refused("face.vtk", "# vtk DataFile Version 3.0\nface\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\n",
          "this is a VTK file, which is not read: convert it to PLY, OBJ or STL");
  refused("face.ply", "# vtk DataFile Version 3.0\nface\nASCII\nDATASET POLYDATA\nPOINTS 1 float\n1 2 3\n",
          "a VTK file");
  refused("cube.xyz", "OFF\n4 1 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n",
          "this is an OFF file, which is not read: convert it to PLY, OBJ or STL");
  refused("cube.gltf", "{ \"asset\": { \"version\": \"2.0\" } }", "a glTF file");
}

}  // namespace
}  // namespace isopach
