// The commands of palpate-tools: main functions, whose arguments begin with the command.
#pragma once

namespace palpate {

int StudyMain(int argc, char** argv);
int PrecomputeMain(int argc, char** argv);
int IdentifyMain(int argc, char** argv);
int CalibrateMain(int argc, char** argv);

}  // namespace palpate
