# SPDX-License-Identifier: Apache-2.0
# The manual page and shell completions, printed by the program.
set(manual_dir ${PROJECT_BINARY_DIR}/manual)
set(manual_files "")
# vesta_printed(FILE DESTINATION arguments...)
function(vesta_printed file destination)
  add_custom_command(OUTPUT ${manual_dir}/${file}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${manual_dir}
    COMMAND vesta ${ARGN} > ${manual_dir}/${file}
    DEPENDS vesta VERBATIM)
  set(manual_files ${manual_files} ${manual_dir}/${file} PARENT_SCOPE)
  install(FILES ${manual_dir}/${file} DESTINATION ${destination} COMPONENT program)
endfunction()
vesta_printed(vesta.1 ${CMAKE_INSTALL_MANDIR}/man1 help --man)
vesta_printed(_vesta ${CMAKE_INSTALL_DATADIR}/zsh/site-functions help --completion=zsh)
vesta_printed(vesta.fish ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d help --completion=fish)
# Debian's zsh searches this folder under /usr.
install(FILES ${manual_dir}/_vesta DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT program)
# bash requires a file with the name of the program.
vesta_printed(vesta ${CMAKE_INSTALL_DATADIR}/bash-completion/completions help --completion=bash)
add_custom_target(vesta_manual ALL DEPENDS ${manual_files})
