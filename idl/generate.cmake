# tenter_idl(NAME FILE.idl): runs fastddsgen in the build and makes the static library tenter_NAME of what it wrote.
# fastddsgen 2.3.0 ends with code 0 after an internal error of its own: whatever looks like one fails the build.

find_package(fastcdr REQUIRED)
find_package(fastrtps 2.9 REQUIRED)  # Debian's name of Fast DDS 2.9
find_program(FASTDDSGEN fastddsgen REQUIRED)

function(tenter_idl name file)
  get_filename_component(stem ${file} NAME_WE)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/generated)
  file(MAKE_DIRECTORY ${folder})
  set(made ${folder}/${stem}.cxx ${folder}/${stem}.h
           ${folder}/${stem}PubSubTypes.cxx ${folder}/${stem}PubSubTypes.h)
  add_custom_command(
    OUTPUT ${made}
    COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/generate.sh ${FASTDDSGEN} ${CMAKE_CURRENT_SOURCE_DIR}/${file} ${folder}
    DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file} ${CMAKE_CURRENT_SOURCE_DIR}/generate.sh
    COMMENT "Generating DDS types from ${file}" VERBATIM)
  add_library(tenter_${name} STATIC ${made})
  add_library(tenter::${name} ALIAS tenter_${name})
  target_include_directories(tenter_${name} SYSTEM PUBLIC ${folder})
  target_compile_options(tenter_${name} PRIVATE -w)
  target_link_libraries(tenter_${name} PUBLIC fastrtps fastcdr)
  if(TENTER_SANITIZE)
    target_compile_options(tenter_${name} PRIVATE -fsanitize=${TENTER_SANITIZE} -fno-omit-frame-pointer)
  endif()
endfunction()
