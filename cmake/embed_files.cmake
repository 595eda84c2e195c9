# cmake -DOUTPUT=... -DFILES="a;b" -DHEADER=... -DFUNCTION=... -P embed_files.cmake: a C++ source that
# holds the files as text, so that the program needs no path to them.
set(source "// Made by cmake/embed_files.cmake.\n#include \"${HEADER}\"\n\nnamespace virtdrive {\n\n")
string(APPEND source "std::span<const EmbeddedFile> ${FUNCTION}() {\n")
string(APPEND source "  static constexpr EmbeddedFile kFiles[] = {\n")
foreach(file IN LISTS FILES)
  file(READ "${file}" text)
  get_filename_component(name "${file}" NAME)
  string(APPEND source "      {\"${name}\", R\"embedded(${text})embedded\"},\n")
endforeach()
string(APPEND source "  };\n  return kFiles;\n}\n\n}  // namespace virtdrive\n")
file(WRITE "${OUTPUT}" "${source}")
