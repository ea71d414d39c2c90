#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/vocabulary/bow_vector.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

/// The paper's way from words to one score per past place (Sec. 3.3), each step a plain function;
/// word_scoring.cpp names its equations. Where the printed text can't be taken literally, the
/// docstring says what is done.
namespace deja_view {

/// What weight a word gets beyond TF-IDF. With p_j = S_j / sum S of the image's words, the expected
/// score is S_bar_j = 1 / (1 - p_j); I(w_j) is one-hot, so that ||I|| ||S_bar|| cos theta_j is
/// S_bar_j itself.
enum class WordWeighting {
  kTfidf,    ///< S_j alone
  kPrinted,  ///< as printed: S_j / (1 + S_bar_j) = S_j (1 - p_j) / (2 - p_j), which *falls*
             ///< with importance: from S_j / 2 at p = 0 to 0 at p = 1
  kText,     ///< as corrected to what the prose asks: S_j / (2 - p_j), from S_j / 2 to S_j
  kSynonym,  ///< as the prose means it: S_j sum_i k(i, j) S_bar_i / sum_i k(i, j) over the image's
             ///< words i, k a kernel on the distance of the word centroids (SynonymKernel)
};

template <>
inline constexpr auto kEnumNames<WordWeighting> = EnumNames("tfidf", "printed", "text", "synonym");

/// A weighted bag of words, sorted by word, each once.
struct WeightedWord {
  WordId word = 0;
  double weight = 0;
};
using WeightedBow = std::vector<WeightedWord>;

/// S_j = (n_j / n) idf_j, idf_j = log(Sum / P_j) from `idf`; n counts all descriptors of the
/// image. In [0, max idf].
WeightedBow TfIdf(const BowVector& bow, const std::function<double(WordId)>& idf);

/// Which words mean nearly the same: k = exp(-(d / sigma)^2 / 2) of the Hamming distance d of their
/// centroids, 1 for a word and itself, 0 beyond `radius` bits.
///
/// The weights ask for k among the words of one image only, some hundreds, which are compared when
/// they are needed: 0.3 ms for 700 words. A table of a vocabulary's pairs would make that 0.1 ms,
/// but cost 19 MB and 5 s (see SumSynonyms). Const methods may be called from several threads.
class SynonymKernel {
 public:
  SynonymKernel(std::shared_ptr<const Vocabulary> vocabulary, int radius, double sigma);

  /// In [0, 1].
  double operator()(WordId a, WordId b) const;

  /// sum_i k(i, j) values_i / sum_i k(i, j) for each word j, over all words i of the bag. One value
  /// per word of `bow`.
  std::vector<double> Average(const WeightedBow& bow, const std::vector<double>& values) const;

 private:
  std::shared_ptr<const Vocabulary> vocabulary_;
  std::vector<double> weights_;  ///< by distance, up to the radius
};

/// The weighting of an image's TF-IDF weights. `kernel` is needed for kSynonym only. p_j is cut at
/// 0.999, since S_bar is infinite for an image of one word.
WeightedBow WeighWords(const WeightedBow& tf_idf,
                       WordWeighting weighting,
                       const SynonymKernel* kernel = nullptr);

/// x.y / (|x| |y|); the printed dot between its two fractions is an equals sign. In [0, 1];
/// 0 when one vector is 0.
double CosineSimilarity(const WeightedBow& a, const WeightedBow& b);

/// Steps by which the weights of the original and the virtual image move.
struct DynamicWeights {
  double alpha = 1.0;
  double beta = 0.5;
};

/// A past keyframe's score from its original and its virtual image.
struct CombinedScore {
  double weight_original = 0;
  double weight_virtual = 0;
  double score = 0;
};

/// Both weights start at 1/2; if S_o > S_v, w_o += alpha (S_o - S_v), else w_v +=
/// beta (S_v - S_o) (the printed second line updates w_v from w_o, which are equal then). Score =
/// w_o S_o + w_v S_v. The weights do not sum to 1: with S in [0, 1] and the default steps the score
/// is in [0, 1.5], reaches 1.5 at S_o = 1, S_v = 0, and is 1 for perfect agreement of both.
CombinedScore CombineScores(double original,
                            double virtual_view,
                            const DynamicWeights& weights = {});

/// What is compared with the threshold r.
enum class LoopThreshold {
  kSum,         ///< the sum over an island's retrieved keyframes, as the paper's r = 2.15 (4 of
                ///< them) and 1.55 (3) must be read; in [0, 1.5 n]
  kPair,        ///< the island's best keyframe; in [0, 1.5]
  kCalibrated,  ///< that over what the current keyframe scores against its own predecessors; >= 0,
                ///< 1 is as alike as the next image
};

template <>
inline constexpr auto kEnumNames<LoopThreshold> = EnumNames("sum", "pair", "calibrated");

/// The number to compare with r; `own` is the score against the predecessors, of which at least
/// 0.05 is taken (an image that shows nothing new is like no other).
double ThresholdScore(const std::vector<double>& island, LoopThreshold threshold, double own);

}  // namespace deja_view
