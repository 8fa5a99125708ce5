// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

// Streams between machines by the installed library; there is no server here.
#include <pcl_ext/link/frame_publisher.h>
#include <pcl_ext/link/frame_subscriber.h>

#include <iostream>

int
main()
{
  pcl_ext::link::SubscriberSettings settings;
  settings.link.servers = "nats://127.0.0.1:1";
  settings.link.site = "cell";
  pcl_ext::link::FramePublisher publisher(settings.link);
  pcl_ext::link::FrameSubscriber subscriber(settings);
  std::cout << publisher.connect() << '\n' << subscriber.connect() << '\n';
  using pcl_ext::link::LinkCode;
  return publisher.connect().code() == LinkCode::CannotConnect &&
                 subscriber.connect().code() == LinkCode::CannotConnect
             ? 0
             : 1;
}
