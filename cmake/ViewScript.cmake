# view_script.cpp from viewer/bundle/viewer.js: the script that reports carry, in pieces that every compiler takes, and its
# digest, by which the page's policy allows this script and no other.
function(isopach_view_script script output)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${script})
  file(READ ${script} text)
  file(SHA256 ${script} digest)
  string(LENGTH "${text}" length)
  set(source "// Made from viewer/bundle/viewer.js by cmake/ViewScript.cmake.\n#include \"isopach/report/view/script.hpp\"\n\n#include <string>\n\nusing namespace std::string_view_literals;\n\n")
  string(APPEND source "namespace isopach {\nnamespace {\nconstexpr std::string_view pieces[] = {\n")
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${text}" ${at} 12000 piece)
    string(APPEND source "R\"isopach(${piece})isopach\"sv,\n")
    math(EXPR at "${at} + 12000")
  endwhile()
  string(APPEND source "};\n\nstd::string joined() {\n  std::string all;\n  for (const std::string_view piece : pieces) all += piece;\n"
    "  return all;\n}\n\n}  // namespace\n\nstd::string_view view_script() {\n  static const std::string all = joined();\n  return all;\n}\n"
    "std::string_view view_script_sha256() { return \"${digest}\"; }\n\n}  // namespace isopach\n")
  file(CONFIGURE OUTPUT ${output} CONTENT "@source@" @ONLY)
endfunction()
