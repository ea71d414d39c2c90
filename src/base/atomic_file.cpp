#include "deja_view/base/atomic_file.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/system_words.hpp"
#include "deja_view/base/temporary_file.hpp"

#include <fstream>

namespace deja_view {

void WriteFileAtomically(const std::filesystem::path& path,
                         const std::function<void(std::ostream&)>& write) {
  TemporaryFile temporary(path);
  std::ofstream stream(temporary.path(), std::ios::binary | std::ios::trunc);
  if (!stream) {
    ThrowInputError("{}: can't be written: {}", path.string(), SystemsWords());
  }
  write(stream);
  stream.close();
  if (!stream) {
    ThrowInputError("{}: can't be written: {}", path.string(), SystemsWords());
  }
  temporary.Rename();
}

}  // namespace deja_view
