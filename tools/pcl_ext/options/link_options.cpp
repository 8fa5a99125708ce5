// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/link_options.h"

#include "console/exit_status.h"
#include "options/setting_options.h"

#include <cstdlib>
#include <string>

namespace pcl_ext::tools {

namespace {

std::string
environment(const char* name)
{
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

} // namespace

void
addLinkOptions(CLI::App& app, link::LinkSettings& settings)
{
  const auto add = [&app](const char* name,
                          std::string& value,
                          const char* type,
                          const std::string& description,
                          const char* variable) {
    app.add_option(name, value, description)->type_name(type)->envname(variable);
  };
  add("--server",
      settings.servers,
      "URLS",
      "NATS servers, tls://HOST:PORT if encrypted (" + settings.servers + ")",
      "PCL_EXT_SERVER");
  add("--site",
      settings.site,
      "NAME",
      "name of the site that has the streams (" + settings.site + ")",
      "PCL_EXT_SITE");
  add("--user",
      settings.user,
      "NAME",
      "the password is in the environment, PCL_EXT_PASSWORD or PCL_EXT_TOKEN",
      "PCL_EXT_USER");
  add("--credentials",
      settings.credentials_file,
      "FILE",
      "JWT and seed, as nsc writes them, in place of a user",
      "PCL_EXT_CREDENTIALS");
  add("--ca",
      settings.ca_file,
      "FILE",
      "certificates to trust, PEM (the system's)",
      "PCL_EXT_CA");
  add("--certificate",
      settings.certificate_file,
      "FILE",
      "certificate of this program for the server, PEM",
      "PCL_EXT_CERTIFICATE");
  add("--key",
      settings.key_file,
      "FILE",
      "private key that belongs to --certificate, PEM",
      "PCL_EXT_KEY");
}

void
completeLinkSettings(link::LinkSettings& settings)
{
  settings.password = environment("PCL_EXT_PASSWORD");
  settings.token = environment("PCL_EXT_TOKEN");
  if (const auto status = link::checkSettings(settings); !status.ok())
    throw UsageError(messageOf(status));
}

} // namespace pcl_ext::tools
