// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
import { button, element } from "./dom";

export type NoticeKind = "error" | "warning" | "info";

/** Messages over the scene: each has a key, under which it is replaced or withdrawn. */
export class Notices {
  readonly root = element("div", { class: "notices", role: "region", "aria-label": "Messages" });
  private readonly shown = new Map<string, HTMLElement>();

  show(key: string, kind: NoticeKind, title: string, lines: readonly string[] = []): void {
    const signature = JSON.stringify([kind, title, lines]);
    const before = this.shown.get(key);
    if (before?.dataset.signature === signature) return;
    const notice = element("div", { class: `notice ${kind}`, role: kind === "error" ? "alert" : "status" });
    notice.dataset.signature = signature;
    const texts = element("div", { class: "notice-text" }, element("strong", {}, title));
    if (lines.length === 1) texts.append(element("p", {}, lines[0]));
    else if (lines.length > 1) {
      const list = element("ul", {}, ...lines.slice(0, 50).map((line) => element("li", {}, line)));
      if (lines.length > 50) list.append(element("li", {}, `and ${lines.length - 50} more`));
      const details = element("details", {}, element("summary", {}, `${lines.length} places`), list);
      details.open = lines.length <= 3;
      texts.append(details);
    }
    notice.append(texts, button("Close message", "close", () => notice.remove()));
    if (before?.isConnected) before.replaceWith(notice);
    else this.root.append(notice);
    this.shown.set(key, notice);
  }

  withdraw(key: string): void {
    this.shown.get(key)?.remove();
    this.shown.delete(key);
  }

  clear(): void {
    for (const key of [...this.shown.keys()]) this.withdraw(key);
  }
}
