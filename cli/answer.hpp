// What a verb found, with all that is needed to write it: a command line writes it at once, a program that calls the
// verb keeps it and asks.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "isopach/apps/accuracy.hpp"
#include "isopach/apps/asymmetry.hpp"
#include "isopach/apps/combine.hpp"
#include "isopach/apps/roughness.hpp"
#include "isopach/apps/scanners.hpp"
#include "isopach/apps/sequence.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/compare/comparison.hpp"
#include "isopach/distance/distance.hpp"
#include "isopach/io/raster_layers.hpp"
#include "isopach/match/matching.hpp"
#include "isopach/measure/parted_cells.hpp"
#include "isopach/report/accuracy.hpp"
#include "isopach/report/picture.hpp"

namespace isopach::cli {

class Answer {
 public:
  virtual ~Answer() = default;

  /// The text of result.json beside `outputs`.
  [[nodiscard]] virtual std::string json(const std::vector<std::string>& outputs) const = 0;
  /// The summary for people.
  [[nodiscard]] virtual std::string text() const = 0;
  /// As the library words them, see for_shell.
  [[nodiscard]] virtual std::vector<std::string> warnings() const { return {}; }
  /// Declares the options that say how this is written.
  virtual void add_output_options(Command& command, Delivery& delivery) const;
  /// Writes and prints what `delivery` asks for; `folder` (null: none) is committed here.
  virtual void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) = 0;
  /// Writes its map as a PNG file; false where it has none.
  virtual bool draw(const std::string&, const MapOptions&, const Context&) const { return false; }
  /// Throws the Error that a run ends with although it has a result: not converged, a tolerance exceeded.
  virtual void require() const {}
};

/// Writes the answer for a shell and ends as it requires; a program gets it as it is.
int finish(std::unique_ptr<Answer> answer, const Delivery& delivery, OutputFolder* folder, Run& run);

struct CompareAnswer : Answer {
  CloudView a, b;
  Comparison comparison;
  std::shared_ptr<const Matching> matching;  ///< null: B was not moved
  std::vector<Tolerance> tolerances;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return comparison.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  bool draw(const std::string& path, const MapOptions& look, const Context& context) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
  void require() const override;
};

/// What becomes of the cells of all tiles, with the comparison that they are of.
using LookAtCells = std::function<void(const PartedCells& cells, const Comparison& c)>;

/// A comparison that was made in tiles: numbers, and a picture in place of the cells.
struct TiledAnswer : Answer {
  Comparison comparison;
  std::optional<RasterLayers> raster;  ///< of --raster
  std::optional<Picture> picture;      ///< where there is a map or a view
  std::vector<Tolerance> tolerances;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return comparison.warnings; }
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
  void require() const override;

  /// What is to be kept of the cells of all tiles; empty: nothing.
  [[nodiscard]] LookAtCells look(const Delivery& delivery, const Context& context);
};

/// Files that need the cells of a comparison in one place: UsageError, naming the option.
void refuse_files_of_cells(const Delivery& delivery);

struct MatchAnswer : Answer {
  CloudView moving, fixed;
  Matching matching;
  ProjectOptions project;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return matching.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
  void require() const override;
};

struct DistanceAnswer : Answer {
  CloudView a, b;
  Distances distances;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return distances.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
};

struct AccuracyAnswer : Answer {
  CloudView reconstruction, reference;
  Accuracy accuracy;
  std::vector<AccuracyCheck> checks;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return accuracy.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  bool draw(const std::string& path, const MapOptions& look, const Context& context) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
  void require() const override;
};

struct ScannersAnswer : Answer {
  CloudView a, b, reference;
  Scanners scanners;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return scanners.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  bool draw(const std::string& path, const MapOptions& look, const Context& context) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
  void require() const override;
};

struct AsymmetryAnswer : Answer {
  CloudView face;
  Asymmetry asymmetry;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return asymmetry.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  bool draw(const std::string& path, const MapOptions& look, const Context& context) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
  void require() const override;
};

struct RoughnessAnswer : Answer {
  CloudView scan, after;  ///< after: empty without a second scan
  Roughness roughness;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return roughness.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  bool draw(const std::string& path, const MapOptions& look, const Context& context) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
};

struct SequenceAnswer : Answer {
  SequenceResult sequence;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return sequence.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
};

struct CombineAnswer : Answer {
  Combination combination;

  [[nodiscard]] std::string json(const std::vector<std::string>& outputs) const override;
  [[nodiscard]] std::string text() const override;
  [[nodiscard]] std::vector<std::string> warnings() const override { return combination.warnings; }
  void add_output_options(Command& command, Delivery& delivery) const override;
  void deliver(const Delivery& delivery, OutputFolder* folder, Run& run) override;
};

/// Scans of a scene, with the text of truth.json less its list of files.
struct SceneAnswer : Answer {
  std::vector<std::pair<std::string, std::shared_ptr<const Cloud>>> scans;  ///< by name, without an ending
  std::string truth;

  [[nodiscard]] std::string json(const std::vector<std::string>&) const override { return truth; }
  [[nodiscard]] std::string text() const override { return {}; }
  void deliver(const Delivery&, OutputFolder*, Run&) override {}
};

/// What is known of files.
struct InfoAnswer : Answer {
  std::string record, words;

  [[nodiscard]] std::string json(const std::vector<std::string>&) const override { return record; }
  [[nodiscard]] std::string text() const override { return words; }
  void deliver(const Delivery&, OutputFolder*, Run&) override {}
};

}  // namespace isopach::cli
