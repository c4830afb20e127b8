# One static library per folder: tenter_library(common_capture SOURCES a.cpp LINK common_base PRIVATE_LINK hdf5).
# A target sees only the folders on its link line plus the system packages named there.

find_package(Threads REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(OpenSSL REQUIRED)

add_library(tenter_options INTERFACE)
target_include_directories(tenter_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(tenter_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wold-style-cast -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  # g++ 12 sees overlaps that are not there in std::string at -O3 (GCC bug 105651)
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # templates fill the compiler's memory, and collecting it is a sixth of its time
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-expand=1000 --param=ggc-min-heapsize=2000000>)
if(TENTER_SANITIZE)
  target_compile_options(tenter_options INTERFACE -fsanitize=${TENTER_SANITIZE} -fno-omit-frame-pointer
    # g++ says so of std::regex and others when it instruments them
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  if(TENTER_SANITIZE MATCHES undefined)
    # Checks at every access through a pointer double the time of the build, checks of its arithmetic are a tenth; a null
    # or a wild pointer, however it came to be, is found by the address sanitizer or by the processor where it is used.
    target_compile_options(tenter_options INTERFACE -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow)
  endif()
  target_link_options(tenter_options INTERFACE -fsanitize=${TENTER_SANITIZE})
endif()

function(tenter_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;PRIVATE_LINK" ${ARGN})
  add_library(tenter_${name} STATIC ${ARG_SOURCES})
  add_library(tenter::${name} ALIAS tenter_${name})
  target_link_libraries(tenter_${name} PUBLIC tenter_options ${ARG_LINK} PRIVATE ${ARG_PRIVATE_LINK})
endfunction()

# tenter_numbers(mechanics): -O3 in release, for a library whose loops run over elements or rows
function(tenter_numbers name)
  target_compile_options(tenter_${name} PRIVATE $<$<CONFIG:Release>:-O3>)
endfunction()

function(tenter_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE tenter_options ${ARG_LINK})
endfunction()
