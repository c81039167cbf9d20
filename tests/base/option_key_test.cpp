#include "isopach/base/option_key.hpp"

#include <gtest/gtest.h>

#include <string>

#include "isopach/base/error.hpp"

namespace isopach {
namespace {

TEST(OptionKey, IsSpelledForTheOneWhoReads) {
  const std::string text = "@max-edge: 0 is no length: leave @border trim out, or give a longer @max-edge";
  EXPECT_EQ(for_shell(text), "--max-edge: 0 is no length: leave --border trim out, or give a longer --max-edge");
  EXPECT_EQ(for_keywords(text), "max_edge: 0 is no length: leave border trim out, or give a longer max_edge");
}

TEST(OptionKey, EndsAtAnyMarkOfASentence) {
  EXPECT_EQ(for_shell("(@folds keep), @sigma1, @sigma2; @unit."), "(--folds keep), --sigma1, --sigma2; --unit.");
  EXPECT_EQ(for_shell("is @reference?"), "is --reference?");
  EXPECT_EQ(for_shell("(@visible)"), "(--visible)");
  EXPECT_EQ(for_shell("@unit"), "--unit");
  EXPECT_EQ(for_shell("take it as it is.\n@unit"), "take it as it is.\n--unit");
}

TEST(OptionKey, IsTheLongestThatFits) {
  EXPECT_EQ(for_shell("@filter-degree, not @filter"), "--filter-degree, not --filter");
  EXPECT_EQ(for_shell("@sigma, not @sigma1"), "--sigma, not --sigma1");
  EXPECT_EQ(for_shell("@start-jaw"), "--start-jaw");
}

TEST(OptionKey, LeavesOtherTextAlone) {
  for (const char* text : {"",
                           "@",
                           "@ unit",
                           "a@",
                           "@@unit",
                           "@unit@",
                           "@nothing-known",
                           "@unit-",
                           "@units",
                           "@unitX",
                           "@Unit",
                           "@unit_2",
                           "@unit/a.ply",
                           "@unit.ply",
                           "user@unit",
                           "user@unit: no such file",
                           "a.@unit",
                           "dir/@unit",
                           "a_@unit",
                           "a-@unit",
                           "'@confidence' is neither a number nor a raster",
                           "\"@unit\"",
                           "`@unit`",
                           "@a:unit",
                           "ä@unit",
                           "@unitä",
                           "--max-edge: 0 is no length",
                           "@media print"}) {
    EXPECT_EQ(for_shell(text), text);
    EXPECT_EQ(for_keywords(text), text);
  }
}

TEST(OptionKey, IsSpelledOnce) {
  const std::string once = for_shell("a.ply: convert it, or say @unit");
  EXPECT_EQ(once, "a.ply: convert it, or say --unit");
  EXPECT_EQ(for_shell(once), once);
  EXPECT_EQ(for_keywords(once), once);
}

TEST(OptionKey, IsFoundBesideNamesOfFiles) {
  EXPECT_EQ(for_shell("user@host/@mask.tif: give another @mask"), "user@host/@mask.tif: give another --mask");
}

TEST(OptionKey, IsKnownByName) {
  EXPECT_TRUE(is_option_key("max-edge"));
  EXPECT_TRUE(is_option_key("accept-doubt"));    // the first of the table
  EXPECT_TRUE(is_option_key("wrinkle-length"));  // the last
  EXPECT_FALSE(is_option_key("max"));
  EXPECT_FALSE(is_option_key("max_edge"));
  EXPECT_FALSE(is_option_key(""));
}

TEST(Error, NamesTheOptionItsMessageBeginsWith) {
  EXPECT_EQ(UsageError("@max-edge: 0 is no length").option(), "max-edge");
  EXPECT_EQ(UsageError("@sigma1 and @sigma2 are needed").option(), "sigma1");
  EXPECT_EQ(UsageError("leave @max-edge out").option(), "");
  EXPECT_EQ(InputError("a.ply: convert it, or say @unit").option(), "");
  EXPECT_EQ(InputError("@mask.tif: cannot be read").option(), "");
  EXPECT_EQ(UsageError("").option(), "");
  EXPECT_STREQ(UsageError("@max-edge: 0 is no length").what(), "@max-edge: 0 is no length");  // unspelled
}

}  // namespace
}  // namespace isopach
