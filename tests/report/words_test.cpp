#include <cmath>

#include <gtest/gtest.h>

#include "isopach/report/page/words.hpp"
#include "tests/report/sample_comparison.hpp"

namespace isopach {
namespace {

constexpr Typography plain = Typography::plain, fine = Typography::fine;

TEST(Words, NumbersKeepSignificantDigitsAndGroupThousands) {
  EXPECT_EQ(number(0, plain), "0");
  EXPECT_EQ(number(-0.0, plain), "0");
  EXPECT_EQ(number(1234.56, plain), "1235");
  EXPECT_EQ(number(12345.6, plain), "12 346");
  EXPECT_EQ(number(99.99999, plain), "100.0");
  EXPECT_EQ(number(-1234567.8, plain), "-1 234 568");
  EXPECT_EQ(number(0.0021234, plain), "0.002123");
  EXPECT_EQ(number(1.23456e-7, plain), "1.235e-07");
  EXPECT_EQ(number(1.23456e-7, fine), "1.235×10⁻⁷");
  EXPECT_EQ(number(-12345.6, fine), "−12\u202f346");
  EXPECT_EQ(number(std::nan(""), plain), "n/a");
  EXPECT_EQ(signed_number(2.5, plain, 2), "+2.5");
  EXPECT_EQ(signed_number(0, plain), "0");
}

TEST(Words, FixedNumbersHaveNoNegativeZero) {
  EXPECT_EQ(fixed_number(-0.001, 2, plain), "0.00");
  EXPECT_EQ(fixed_number(5405100.126, 2, plain), "5 405 100.13");
}

TEST(Words, UnknownUnitsAreNeverMetres) {
  EXPECT_EQ(unit_text("unknown", 3), "units³");
  EXPECT_EQ(unit_text("us-ft", 2), "US ft²");
  EXPECT_EQ(unit_text("mm"), "mm");
  EXPECT_EQ(unit_sentence("unknown"), "units unknown (as in the files)");
}

TEST(Words, HeightsMayHaveAUnitOfTheirOwn) {
  Comparison c;
  c.unit = "m";
  EXPECT_EQ(measured_unit(c, 1), "m");  // the files do not say what heights are in
  c.b.vertical_unit = "us-ft";
  EXPECT_EQ(measured_unit(c, 1), "US ft");
  EXPECT_EQ(measured_unit(c, 2), "m²");
  EXPECT_EQ(measured_unit(c, 3), "US ft·m²");
  c.options.unit = "m";  // --unit speaks of both
  EXPECT_EQ(measured_unit(c, 3), "m³");
  c.options.unit = "";
  c.frame.rotation = {0, 1, 0, 0, 0, 1, 1, 0, 0};  // along x, d is a mixture
  EXPECT_EQ(height_unit(c), "unknown");
}

TEST(Words, HeightsAreNeverDegrees) {
  Comparison c;
  c.unit = "deg";
  EXPECT_EQ(measured_unit(c, 1), "units");
  EXPECT_EQ(measured_unit(c, 3), "units·deg²");
}

TEST(Words, InvalidUtf8AndControlCharactersAreReplaced) {
  EXPECT_EQ(clean_utf8("héllo → 😀"), "héllo → 😀");
  EXPECT_EQ(clean_utf8("a\xff\x62"), "a\uFFFDb");
  EXPECT_EQ(clean_utf8("a\nb"), "a\uFFFDb");
  EXPECT_EQ(clean_utf8("\xc0\xaf"), "\uFFFD\uFFFD");            // overlong
  EXPECT_EQ(clean_utf8("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");  // surrogate
  EXPECT_EQ(clean_utf8("cut \xe2\x82"), "cut \uFFFD\uFFFD");
}

TEST(Words, MessagesAreSpelledForTheCommandLineAndClean) {
  EXPECT_EQ(message_text("a\nb.ply: leave @border hull out"), "a\uFFFDb.ply: leave --border hull out");
  EXPECT_EQ(message_text("user@host"), "user@host");
}

TEST(Words, InputNameIsTheLastPartOfThePath) {
  InputSummary in;
  in.role = "A";
  EXPECT_EQ(input_name(in), "A");
  in.path = "/some/where/scan.laz";
  EXPECT_EQ(input_name(in), "scan.laz");
}

TEST(Words, TheHeadlineSaysWhichLiesBelow) {
  const auto flat = [](double, double) { return 0.0; };
  const auto say = [](const Comparison& c) {
    return headline(c, [](const std::string&, double v, int) { return number(v, plain); });
  };
  const std::string lower = say(sample::make({}, flat, [](double, double) { return -0.5; }));
  EXPECT_EQ(lower, "B lies on average 0.5000 below A: 0 gained and 50.00 lost on 100.0.");
  EXPECT_NE(say(sample::make({}, flat, [](double, double) { return 2.0; })).find("above A"), std::string::npos);
  EXPECT_NE(say(sample::make({}, flat, flat)).find("do not differ"), std::string::npos);
}

}  // namespace
}  // namespace isopach
