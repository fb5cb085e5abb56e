#include "tools/completion.h"

#include <memory>

#include <fmt/core.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "tools/console.h"

namespace swept {
namespace {

std::string options_of(const CLI::App& app) {
  std::string words;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) words += (words.empty() ? "--" : " --") + name;
  return words;
}

}  // namespace

std::string completion_script(const CLI::App& app, bool zsh) {
  std::string commands, cases;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_group().empty()) continue;  // not for users
    commands += command->get_name() + ' ';
    cases += fmt::format("    {}) words=\"{}\" ;;\n", command->get_name(), options_of(*command));
  }
  // Files where no option is begun.
  return fmt::format(R"({}_swept() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" words
  case "${{COMP_WORDS[1]}}" in
{}    *) words="{}{}" ;;
  esac
  if [[ $COMP_CWORD -gt 1 && $word != -* ]]; then
    COMPREPLY=($(compgen -f -- "$word"))
  else
    COMPREPLY=($(compgen -W "$words" -- "$word"))
  fi
}}
complete -o filenames -F _swept swept
)",
                     zsh ? "autoload -U +X bashcompinit && bashcompinit\n" : "", cases, commands,
                     options_of(app));
}

void add_completion_command(CLI::App& app) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("completion", "Print a script that completes words in a shell");
  command->add_option("shell", *shell, "bash or zsh")->required()->check(CLI::IsMember({"bash", "zsh"}));
  command->footer(
      std::string(
          "Examples:\n  source <(swept completion bash)\n  swept completion zsh > ~/.zsh/swept && source "
          "~/.zsh/swept\n\n") +
      exit_codes_help);
  command->callback([shell, &app] { fmt::print("{}", completion_script(app, *shell == "zsh")); });
}

}  // namespace swept
