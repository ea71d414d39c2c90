#include "deja_view/nerf/checkpoint.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/nerf/scene_cells.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "closed_form.hpp"
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view::nerf {
namespace {

namespace fs = std::filesystem;

class CheckpointTest : public testing::Test {
 protected:
  CheckpointTest()
      : directory_(fs::temp_directory_path() /
                   ("deja_view_checkpoint_" + std::to_string(::getpid()))) {
    fs::create_directories(directory_);
  }
  ~CheckpointTest() override { fs::remove_all(directory_); }

  const fs::path& directory() const { return directory_; }
  fs::path WriteSample() const {
    RadianceField field = ConstantField(2, 0.3F, 3);
    field.exposures = {{"one", 17, 1.5F, 0.1F, {}}, {"two", 18, 0.5F, -0.1F, {}}};
    field.occupancy.Set(5, false);
    field.geometry.parameters()[3] = 4.25F;
    WriteField(directory_ / "model", field);
    return directory_ / "model";
  }
  static std::vector<char> Bytes(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  fs::path Write(const std::vector<char>& bytes) const {
    std::ofstream stream(directory_ / "changed", std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return directory_ / "changed";
  }

 private:
  fs::path directory_;
};

TEST_F(CheckpointTest, ComesBackWhole) {
  const fs::path path = WriteSample();
  const RadianceField field = ReadField(path);
  EXPECT_EQ(field.channels, 3);
  EXPECT_EQ(field.box.max.x(), 3);
  EXPECT_EQ(field.geometry.parameters()[3], 4.25F);
  EXPECT_FALSE(field.occupancy.IsOccupied(5));
  ASSERT_EQ(field.exposures.size(), std::size_t{2});
  EXPECT_EQ(field.exposures[1].image, "two");
  EXPECT_EQ(field.exposures[1].stamp_ns, 18);
  EXPECT_EQ(field.exposures[1].gain, 0.5F);
  WriteField(path.string() + "2", field);
  EXPECT_EQ(Bytes(path), Bytes(path.string() + "2"));
}

TEST_F(CheckpointTest, SubMapsComeBackWithTheirCells) {
  RadianceField field = ReadField(WriteSample());
  EXPECT_FALSE(field.cells.IsCut());
  field.cells = {1, CutByCameras({{0, 0, 0}, {2, 0, 0}, {2, 5, 0}}, 3)};
  const fs::path path = directory() / "sub_map";
  WriteField(path, field);
  const RadianceField read = ReadField(path);
  EXPECT_EQ(read.cells.index, 1);
  EXPECT_TRUE(read.cells.cells == field.cells.cells);
  EXPECT_TRUE(std::isinf(read.cells.cells[0].min.x()));
  EXPECT_EQ(read.exposures[1].image, "two");
}

TEST_F(CheckpointTest, CellsThatMakeNoSenseAreAnError) {
  RadianceField field = ReadField(WriteSample());
  const auto is_refused = [&](const SceneCells& cells) {
    field.cells = cells;
    WriteField(directory() / "odd", field);
    try {
      ReadField(directory() / "odd");
    } catch (const InputError&) {
      return true;
    }
    return false;
  };
  const std::vector<SceneCell> cells = CutByCameras({{0, 0, 0}, {2, 0, 0}}, 2);
  EXPECT_FALSE(is_refused({1, cells}));
  EXPECT_TRUE(is_refused({2, cells}));
  EXPECT_TRUE(is_refused({-1, cells}));
  std::vector<SceneCell> empty = cells;
  empty[0].max.x() = empty[0].min.x();
  EXPECT_TRUE(is_refused({1, empty}));
  empty[0].max.x() = NAN;
  EXPECT_TRUE(is_refused({1, empty}));
}

TEST_F(CheckpointTest, StepsThatLeadNowhereAreAnError) {
  RadianceField field = ReadField(WriteSample());
  const fs::path path = directory() / "still";
  for (const float step : {0.0F, -1.0F, 1e-9F, NAN}) {
    field.march.min_step = step;
    WriteField(path, field);
    EXPECT_THROW(ReadField(path), InputError) << step;
  }
}

TEST_F(CheckpointTest, FramesComeBackWithAndWithoutCells) {
  RadianceField field = ReadField(WriteSample());
  EXPECT_TRUE(field.frame.IsWorld());
  const fs::path path = directory() / "framed";
  field.frame = {true, {2.5, {ExpSo3({0.1, 0.2, 0.3}), {4, 5, 6}}}};
  for (const int cells : {0, 2}) {
    field.cells = {0,
                   cells == 0 ? std::vector<SceneCell>() : CutByCameras({{0, 0, 0}, {2, 0, 0}}, 2)};
    WriteField(path, field);
    const RadianceField read = ReadField(path);
    EXPECT_TRUE(read.cells.cells == field.cells.cells);
    EXPECT_EQ(RequireFrame(read.frame, path).scale, 2.5);
    EXPECT_EQ(read.frame.W_N.T_A_B.t, field.frame.W_N.T_A_B.t);
    EXPECT_EQ(read.frame.W_N.T_A_B.q.coeffs(), field.frame.W_N.T_A_B.q.coeffs());
  }
  field.frame = {false, {}};
  WriteField(path, field);
  EXPECT_FALSE(ReadField(path).frame.is_known);
  EXPECT_THROW(RequireFrame(ReadField(path).frame, path), InputError);
  field.frame = {true, {-1, {}}};
  WriteField(path, field);
  EXPECT_THROW(ReadField(path), InputError);
}

TEST_F(CheckpointTest, EveryCutIsAnError) {
  const std::vector<char> bytes = Bytes(WriteSample());
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 8) {
    EXPECT_THROW(
        ReadField(Write({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)})),
        InputError)
        << size;
  }
}

TEST_F(CheckpointTest, EveryFlippedBitIsAnError) {
  std::vector<char> bytes = Bytes(WriteSample());
  for (std::size_t at = 0; at < bytes.size(); at += at < 256 ? 1 : at / 4) {
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    EXPECT_THROW(ReadField(Write(bytes)), InputError) << at;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
  }
}

TEST_F(CheckpointTest, BytesTooManyAreAnError) {
  std::vector<char> bytes = Bytes(WriteSample());
  bytes.push_back(0);
  EXPECT_THROW(ReadField(Write(bytes)), InputError);
}

TEST_F(CheckpointTest, MissingFileIsAnError) {
  EXPECT_THROW(ReadField("/nonexistent/model"), InputError);
}

}  // namespace
}  // namespace deja_view::nerf
